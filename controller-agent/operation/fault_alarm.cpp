#include "operation/fault_alarm.hpp"

#include <algorithm>
#include <iterator>

namespace headstock::operation {
namespace {

using axes::FaultKind;

struct Row {
  std::string_view profile;  // prefix
  FaultKind kind;
  char axis;  // 0: any
  std::string_view code;
};

// FANUC: 0i-D L73136, L73247, L73250, L73535, L74513. GSK: the drive-alarm numbers of the axes (2000TC
// L11300, 218T L6969), for a drive of theirs reports its own position error. K2000TC and 200T have no number
// for it but that of a drive in alarm.
constexpr Row kRows[] = {
    {"fanuc", FaultKind::following_error_moving, 0, "SV0411"},
    {"fanuc", FaultKind::following_error_stopped, 0, "SV0410"},
    {"fanuc", FaultKind::synchronous_error, 0, "SV0005"},
    {"fanuc", FaultKind::tap_error, 0, "SP0741"},
    {"fanuc", FaultKind::spindle_fluctuation, 0, "OH0704"},
    {"gsk-2000tc", FaultKind::following_error_moving, 'X', "221"},
    {"gsk-2000tc", FaultKind::following_error_moving, 'Z', "222"},
    {"gsk-2000tc", FaultKind::following_error_moving, 'Y', "228"},
    {"gsk-2000tc", FaultKind::following_error_stopped, 'X', "221"},
    {"gsk-2000tc", FaultKind::following_error_stopped, 'Z', "222"},
    {"gsk-2000tc", FaultKind::following_error_stopped, 'Y', "228"},
    {"gsk-2000tc", FaultKind::spindle_fluctuation, 0, "016"},
    {"gsk-218t", FaultKind::following_error_moving, 'X', "221"},
    {"gsk-218t", FaultKind::following_error_moving, 'Z', "222"},
    {"gsk-218t", FaultKind::following_error_stopped, 'X', "221"},
    {"gsk-218t", FaultKind::following_error_stopped, 'Z', "222"},
    {"lathe-200t", FaultKind::following_error_moving, 0, "A14"},
    {"lathe-200t", FaultKind::following_error_stopped, 0, "A14"},
};

struct Own {
  FaultKind kind;
  MachineAlarm alarm;
};
constexpr Own kOwn[] = {
    {FaultKind::following_error_moving,
     {"HS0020", "Following error too large while moving", "移动中跟随误差过大"}},
    {FaultKind::following_error_stopped,
     {"HS0021", "Following error too large at rest", "停止时跟随误差过大"}},
    {FaultKind::synchronous_error, {"HS0022", "Synchronous axes have parted", "同步轴偏差过大"}},
    {FaultKind::tap_error, {"HS0023", "Spindle and axis out of step in tapping", "攻丝时主轴与进给轴失步"}},
    {FaultKind::spindle_fluctuation, {"HS0024", "Spindle speed fluctuates too much", "主轴转速波动过大"}},
};

}  // namespace

MachineAlarm fault_alarm(std::string_view profile, const axes::Fault& fault, char axis) {
  if (fault.kind == FaultKind::overtravel) return overtravel_alarm(profile, axis, fault.positive);
  const auto* own = std::find_if(std::begin(kOwn), std::end(kOwn),
                                 [&](const Own& entry) { return entry.kind == fault.kind; });
  MachineAlarm alarm = own == std::end(kOwn) ? kOwn[0].alarm : own->alarm;
  for (const Row& row : kRows) {
    if (!profile.starts_with(row.profile) || row.kind != fault.kind) continue;
    if (row.axis != 0 && row.axis != axis) continue;
    alarm.code = row.code;
    break;
  }
  return alarm;
}

}  // namespace headstock::operation
