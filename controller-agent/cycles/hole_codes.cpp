// Which code drills, bores or taps how on which control.
#include "cycles/hole_codes.hpp"

namespace headstock::cycles {
namespace {

using enum HoleIn;
using enum HoleBottom;

constexpr HoleKind kDrill{};
constexpr HoleKind kDwell{once, dwell};
constexpr HoleKind kPeckBack{pecks_back};
constexpr HoleKind kPeckOut{pecks_out};
constexpr HoleKind kFeedOut{once, nothing, HoleOut::feed};
constexpr HoleKind kDwellFeedOut{once, dwell, HoleOut::feed};
constexpr HoleKind kStop{once, spindle_stop};
constexpr HoleKind kFine{once, orient_shift};
constexpr HoleKind kBack{up, orient_shift};
constexpr HoleKind kManual{once, operator_out};
constexpr HoleKind kTapRight{once, nothing, HoleOut::feed, HoleTap::right};
constexpr HoleKind kTapLeft{once, nothing, HoleOut::feed, HoleTap::left};

constexpr HoleCode kMill[] = {{730, "G73", kPeckBack},
                              {740, "G74", kTapLeft},
                              {760, "G76", kFine},
                              {810, "G81", kDrill},
                              {820, "G82", kDwell},
                              {830, "G83", kPeckOut},
                              {840, "G84", kTapRight},
                              {842, "G84.2", kTapRight, 0, true},
                              {843, "G84.3", kTapLeft, 0, true},
                              {850, "G85", kFeedOut},
                              {860, "G86", kStop},
                              {870, "G87", kBack},
                              {880, "G88", kManual},
                              {890, "G89", kDwellFeedOut}};

// 0i-T: face (Z) and side (X). Q makes G83/G87 peck; which way, a parameter says.
constexpr HoleCode kTurning[] = {{810, "G81", kDrill, 'Z'},
                                 {820, "G82", kDwell, 'Z'},
                                 {830, "G83", {pecks_out, dwell}, 'Z'},
                                 {831, "G83.1", {pecks_back, dwell}, 'Z'},
                                 {840, "G84", kTapRight, 'Z'},
                                 {842, "G84.2", kTapRight, 'Z', true},
                                 {850, "G85", kDwellFeedOut, 'Z'},
                                 {870, "G87", {pecks_out, dwell}, 'X'},
                                 {880, "G88", kTapRight, 'X'},
                                 {890, "G89", kDwellFeedOut, 'X'}};

constexpr HoleCode kK2000[] = {
    {810, "G81", kDrill},    {820, "G82", kDwell},     {830, "G83", kPeckOut}, {835, "G83.5", kPeckBack},
    {840, "G84", kTapRight}, {845, "G84.5", kTapLeft}, {850, "G85", kFeedOut}, {860, "G86", kStop},
    {865, "G86.5", kFine},   {870, "G87", kBack},      {880, "G88", kManual},  {890, "G89", kDwellFeedOut}};

constexpr HoleCode k200t[] = {{730, "G73", kPeckBack, 'Z'}, {810, "G81", kDrill, 'Z'},
                              {820, "G82", kDwell, 'Z'},    {830, "G83", {pecks_out_feed}, 'Z'},
                              {850, "G85", kFeedOut, 'Z'},  {860, "G86", kStop, 'Z'}};

}  // namespace

std::span<const HoleCode> hole_codes(HoleFamily family) {
  switch (family) {
    case HoleFamily::mill:
      return kMill;
    case HoleFamily::turning:
      return kTurning;
    case HoleFamily::k2000:
      return kK2000;
    case HoleFamily::lathe_200t:
      return k200t;
    case HoleFamily::none:
      break;
  }
  return {};
}

const HoleCode* hole_code(HoleFamily family, std::int16_t tenths) {
  for (const HoleCode& one : hole_codes(family)) {
    if (one.tenths == tenths) return &one;
  }
  return nullptr;
}

}  // namespace headstock::cycles
