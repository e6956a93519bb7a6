#include "operation/acceleration_modes.hpp"

#include <array>

namespace headstock::operation {
namespace {

using enum MotionKind;
using enum AccelerationUnit;
using enum Ramp;

// 2000TC: S168 (L12171-L12199)
constexpr ModeBit kCurved{"S168.0", true, true}, kLinear{"S168.0", false, true}, kBefore{"S168.1", false},
    kAfter{"S168.1", true};
constexpr ModeBit kCutCurved{"S168.2", true, true}, kCutLinear{"S168.2", false, true},
    kCutBefore{"S168.3", false, true}, kCutAfter{"S168.3", true, true};
constexpr ModeBit kThreadS{"S168.4", true}, kThreadLinear{"S168.4", false};
constexpr ModeBit kJogLinear{"S168.6", false}, kJogCurved{"S168.6", true};
constexpr ModeBit kHandleLinear{"S168.7", false, true}, kHandleCurved{"S168.7", true, true};
// 218T: ACC4…ACC1 are P009.7…P009.4: 0000 linear before, 0001 S before, 0100 linear after (L4906-L4912)
constexpr ModeBit k218S{"P009.4", true}, k218NotS{"P009.4", false}, k218After{"P009.6", true},
    k218Before{"P009.6", false};
// 0i-D
constexpr ModeBit kFrp{"19501#5", true}, kNotFrp{"19501#5", false}, kLrp{"1401#1", true};
constexpr ModeBit kCtl{"1610#0/", true}, kNotCtl{"1610#0/", false}, kCtb{"1610#1/", true},
    kNotCtb{"1610#1/", false};
constexpr ModeBit kLs2{"1602#6", true}, kNotLs2{"1602#6", false}, kBs2{"1602#3", true},
    kNotBs2{"1602#3", false};
// K2000TC
constexpr ModeBit kNotK2Lrp{"P0004.1", false}, kK2Lrp{"P0004.1", true};

constexpr AccelerationRow kRows[] = {
    // FANUC 0i-D L21277, L22088-L22162, L47477-L47497, L55676-L55887. Positioning ends at exact stops and is
    // straight, so that its acceleration after interpolation is the same motion as before it.
    {"fanuc-0i", rapid, both, "1620/", 0, time_to_rapid, kNotFrp},
    {"fanuc-0i", rapid, both, "1621/", 0, bell, kNotFrp},
    {"fanuc-0i", rapid, both, "1671/", 0, acceleration, kFrp, kLrp},
    {"fanuc-0i", rapid, both, "1672", 0, bell, kFrp, kLrp},
    {"fanuc-0i", cutting, both, "1622/", 0, after_exponential, kNotCtl, kNotCtb},
    {"fanuc-0i", cutting, both, "1622/", 0, after_linear, kCtl, kNotCtb},
    {"fanuc-0i", cutting, both, "1622/", 0, after_bell, kCtb},
    {"fanuc-0i", cutting_ahead, both, "1660/", 0, acceleration},
    {"fanuc-0i-m", cutting_ahead, both, "1772", 0, bell},
    {"fanuc-0i", cutting_ahead, both, "1769/", 0, after_exponential, kNotLs2, kNotBs2},
    {"fanuc-0i", cutting_ahead, both, "1769/", 0, after_linear, kLs2, kNotBs2},
    {"fanuc-0i", cutting_ahead, both, "1769/", 0, after_bell, kBs2},
    {"fanuc-0i", thread, both, "1626/", 0, time_to_feed},
    {"fanuc-0i", jog, both, "1624/", 0, time_to_feed},
    // GSK 2000TC S168, P305-P326 (L12171-L12199, L13677-L13800)
    {"gsk-2000tc", rapid, both, "P305", 'X', time_to_rapid, kLinear, kBefore},
    {"gsk-2000tc", rapid, both, "P306", 'Z', time_to_rapid, kLinear, kBefore},
    {"gsk-2000tc", rapid, both, "P307", 'X', s_to_rapid, kCurved, kBefore},
    {"gsk-2000tc", rapid, both, "P308", 'Z', s_to_rapid, kCurved, kBefore},
    {"gsk-2000tc", rapid, both, "P309", 'X', time_to_rapid, kLinear, kAfter},
    {"gsk-2000tc", rapid, both, "P310", 'Z', time_to_rapid, kLinear, kAfter},
    {"gsk-2000tc", rapid, both, "P311", 'X', after_exponential, kCurved, kAfter},
    {"gsk-2000tc", rapid, both, "P312", 'Z', after_exponential, kCurved, kAfter},
    {"gsk-2000tc", cutting, both, "P313", 0, time_to_highest, kCutLinear, kCutBefore},
    {"gsk-2000tc", cutting, both, "P314", 0, s_to_highest, kCutCurved, kCutBefore},
    {"gsk-2000tc", cutting, both, "P315", 0, after_linear, kCutLinear, kCutAfter},
    {"gsk-2000tc", cutting, both, "P316", 0, after_exponential, kCutCurved, kCutAfter},
    {"gsk-2000tc", thread, both, "P321", 0, time_to_highest, kThreadLinear},
    {"gsk-2000tc", thread, both, "P324", 0, s_to_highest, kThreadS},
    {"gsk-2000tc", jog, both, "P317", 0, time_to_feed, kJogLinear},
    {"gsk-2000tc", jog, both, "P318", 0, time_to_feed, kJogCurved},
    {"gsk-2000tc", handle, both, "P319", 0, time_to_feed, kHandleLinear},
    {"gsk-2000tc", handle, both, "P320", 0, time_to_feed, kHandleCurved},
    // GSK 218T P009.4-.7, P023-P031, P069 (L4654-L4680, L5078-L5148)
    {"gsk-218t", rapid, both, "P023", 'X', time_to_rapid, k218NotS},
    {"gsk-218t", rapid, both, "P024", 'Z', time_to_rapid, k218NotS},
    {"gsk-218t", rapid, both, "P025", 'X', s_to_rapid, k218S},
    {"gsk-218t", rapid, both, "P026", 'Z', s_to_rapid, k218S},
    {"gsk-218t", cutting, both, "P031", 0, time_to_highest, k218NotS, k218Before},
    {"gsk-218t", cutting, both, "P031", 0, after_linear, k218NotS, k218After},
    {"gsk-218t", cutting, up, "P029", 0, s_to_highest, k218S},
    {"gsk-218t", cutting, down, "P030", 0, s_to_highest, k218S},
    {"gsk-218t", thread, both, "P069", 0, time_to_highest},
    {"gsk-218t", jog, both, "P031", 0, time_to_highest, k218NotS},
    {"gsk-218t", jog, up, "P029", 0, s_to_highest, k218S},
    {"gsk-218t", jog, down, "P030", 0, s_to_highest, k218S},
    // K2000TC: before interpolation, over blocks (L4826-L4889, table L4905)
    {"k2000tc", rapid, up, "P6432", 0, mean, kK2Lrp},
    {"k2000tc", rapid, down, "P6433", 0, mean, kK2Lrp},
    {"k2000tc", rapid, both, "P6440", 0, mean, kNotK2Lrp},
    {"k2000tc", cutting, up, "P6430", 0, mean},
    {"k2000tc", cutting, down, "P6431", 0, mean},
    {"k2000tc", thread, up, "P6480", 0, mean},
    {"k2000tc", thread, down, "P6481", 0, mean},
    {"k2000tc", retreat, both, "P6483", 0, mean},  // L3961; of it J/K (L12834)
    // 200T/300T: time from standing to the highest cutting feed, for every motion (L8016-L8055)
    {"lathe-200t", rapid, both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", rapid, both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", cutting, both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", cutting, both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", thread, both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", thread, both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", jog, both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", jog, both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", handle, both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", handle, both, "AX2.2", 'Z', time_to_highest},
};

// K2000TC: its manual names five curves (L4826) and six path smoothers (L5175-L5305), and gives neither the
// numbers of the curves nor what a smoother of some order does.
constexpr std::string_view kMeanOnly = "the mean acceleration, with the jerk of the machine file",
                           kTolerance = "the tolerance of the machine file";
constexpr AccelerationGap kGaps[] = {
    {"k2000tc", "P6410", kMeanOnly},           {"k2000tc", "P6411", kMeanOnly},
    {"k2000tc", "P6412", kMeanOnly},           {"k2000tc", "P6413", kMeanOnly},
    {"k2000tc", "P6416", kMeanOnly},           {"k2000tc", "P6458", kTolerance},
    {"k2000tc", "P6460", kTolerance},          {"k2000tc", "P6468", kTolerance},
    {"k2000tc", "P6482", kMeanOnly},           {"gsk-218t", "P009.5", "as if it were 0"},
    {"gsk-218t", "P009.7", "as if it were 0"},
};

struct Words {
  std::string_view curve, place, value;
};
constexpr std::string_view kBeforeWord = "before", kAfterWord = "after";
constexpr std::array<Words, 11> kWords{{
    {"linear", kBeforeWord, "mm/s²"},
    {"linear", kBeforeWord, "ms to the rapid rate"},
    {"linear", kBeforeWord, "ms to the feed"},
    {"linear", kBeforeWord, "ms to the highest cutting feed"},
    {"linear", kBeforeWord, "(m/min)/s along the path"},
    {"S", kBeforeWord, "ms to the rapid rate"},
    {"S", kBeforeWord, "ms to the highest cutting feed"},
    {"bell", kBeforeWord, "ms in which the acceleration rises and falls"},
    {"linear", kAfterWord, "ms"},
    {"bell", kAfterWord, "ms"},
    {"exponential", kAfterWord, "ms (time constant)"},
}};
constexpr std::array<std::string_view, kMotionKinds> kNames{
    "rapid", "cutting", "cutting, look-ahead", "thread", "away from a thread", "jog", "handle"};

}  // namespace

std::span<const AccelerationRow> acceleration_rows() {
  return kRows;
}
std::span<const AccelerationGap> acceleration_gaps() {
  return kGaps;
}
std::string_view name_of(MotionKind kind) {
  return kNames[static_cast<std::size_t>(kind)];
}
std::string_view curve_of(AccelerationUnit unit) {
  return kWords[static_cast<std::size_t>(unit)].curve;
}
std::string_view place_of(AccelerationUnit unit) {
  return kWords[static_cast<std::size_t>(unit)].place;
}
std::string_view value_of(AccelerationUnit unit) {
  return kWords[static_cast<std::size_t>(unit)].value;
}

}  // namespace headstock::operation
