// The machine that a profile stands for while nobody has described the real one.
#include <algorithm>
#include <array>

#include "machine/machine.hpp"

namespace headstock::machine {
namespace {

struct ProfileDefaults {
  std::string_view profile;
  Kind kind;
  double rapid_mm_min;  // of Z; a lathe's X slide has half of it
  double max_feed_mm_min;
  double max_acceleration_mm_s2;
  double max_rpm;
};

constexpr std::array<ProfileDefaults, 6> kProfiles{{
    {"fanuc-0i-t", Kind::lathe, 16'000, 6'000, 2'000, 4'000},
    {"fanuc-0i-m", Kind::mill, 20'000, 10'000, 2'000, 8'000},
    {"gsk-2000tc", Kind::lathe, 12'000, 6'000, 1'500, 3'000},
    {"gsk-218t", Kind::lathe, 10'000, 5'000, 1'500, 3'000},
    {"k2000tc", Kind::lathe, 12'000, 6'000, 1'500, 4'000},
    {"lathe-200t", Kind::lathe, 6'000, 3'000, 800, 2'000},
}};

Axis axis_of(char name, const ProfileDefaults& defaults) {
  const bool cross_slide = defaults.kind == Kind::lathe && name == 'X';
  Axis axis;
  axis.name = name;
  axis.designation = cross_slide ? Designation::diameter : Designation::radius;
  axis.rapid_mm_min = cross_slide ? defaults.rapid_mm_min / 2 : defaults.rapid_mm_min;
  axis.max_feed_mm_min = std::min(defaults.max_feed_mm_min, axis.rapid_mm_min);
  axis.max_acceleration_mm_s2 = defaults.max_acceleration_mm_s2;
  axis.max_jerk_mm_s3 = 50'000;
  // Wide on both sides of zero: without a file no workpiece offset is known either, so programs are run about
  // 0.
  axis.min_mm = -1'000;
  axis.max_mm = 1'000;
  return axis;
}

}  // namespace

std::optional<Machine> default_machine(std::string_view profile) {
  const auto defaults =
      std::find_if(kProfiles.begin(), kProfiles.end(),
                   [&](const ProfileDefaults& candidate) { return candidate.profile == profile; });
  if (defaults == kProfiles.end()) return std::nullopt;

  Machine machine;
  machine.name = defaults->profile;
  machine.profile = defaults->profile;
  machine.kind = defaults->kind;
  for (const char name : machine.kind == Kind::mill ? std::string_view("XYZ") : std::string_view("XZ"))
    machine.axes.push_back(axis_of(name, *defaults));
  machine.spindle.max_rpm = defaults->max_rpm;
  return machine;
}

}  // namespace headstock::machine
