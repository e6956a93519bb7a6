#include "tools/tool_setting.hpp"

namespace headstock::tools {

double measured_offset(const Touch& touch, OffsetSign sign) {
  return touch.in_force + static_cast<int>(sign) * (touch.shown - touch.place);
}

double fixed_point_offset(double relative, double reference) {
  return reference + relative;
}

double corrected_offset(double stored, double correction) {
  return stored + correction;
}

double trimmed_offset(double stored, double part_change) {
  return stored - part_change;
}

}  // namespace headstock::tools
