// Variables by number: locals, commons, and what the system answers (L18600-L19500).
#include <cmath>

#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {
namespace {

using k2000::Error;

constexpr std::uint32_t kFirstCommon = 100, kFirstRetained = 500, kLastCommon = 999;

// A number that is whole is an INT: a program may jump by it and shift it.
Value of_number(double value) {
  if (value == std::floor(value) && std::fabs(value) < 2147483648.0)
    return Value::of_int(static_cast<std::int64_t>(value));
  return Value::of_double(value);
}

}  // namespace

std::array<Value, k2000::kLocals>& Language::locals() {
  std::size_t i = level(ex_).own_locals ? ex_.frames.size() - 1 : 0;
  for (std::size_t k = std::min(levels_.size(), ex_.frames.size()); k-- > 0;) {
    if (!levels_[k].own_locals) continue;
    i = k;
    break;
  }
  return levels_[i].locals;
}

Error Language::read(std::uint32_t number, Value& value) {
  if (number < k2000::kLocals) {
    value = locals()[number];
    return Error::none;
  }
  if (number >= kFirstCommon && number <= kLastCommon) {
    const auto stored = ex_.data.common_variables.find(number);
    if (stored == ex_.data.common_variables.end()) {
      value = {};
      return Error::none;
    }
    const auto typed = commons_.find(number);
    // The operator may have changed it since: then its type is that of the number.
    value = typed != commons_.end() && typed->second.number() == stored->second ? typed->second
                                                                                : of_number(stored->second);
    return Error::none;
  }
  return read_system(number, value);
}

Error Language::write(std::uint32_t number, const Value& value) {
  ex_.idle_jumps = 0;  // the program goes on
  if (number < k2000::kLocals) {
    locals()[number] = value;
    return Error::none;
  }
  if (number >= kFirstCommon && number <= kLastCommon) {
    auto& stored = ex_.data.common_variables;
    const auto found = stored.find(number);
    const double before = found == stored.end() ? 0 : found->second;
    commons_[number] = value;
    if (value.is_null()) {
      if (found != stored.end()) stored.erase(found);
    } else {
      stored[number] = value.number();
    }
    if (number >= kFirstRetained)
      ex_.report_change("variable/" + std::to_string(number), before, value.number());
    return Error::none;
  }
  return write_system(number, value);
}

namespace {

// A column of the offset page that variables reach by number.
struct OffsetColumn {
  bool is_axis = true;
  std::size_t axis = 0;
  bool wear = false;
};

// #10001 … #88032: axis 1…8, geometry or wear; #90001, #98001: nose radius (L19107-L19319).
bool offset_column(std::uint32_t number, std::size_t axes, OffsetColumn& column, std::size_t& row) {
  if (number < 10'001 || number > 98'032) return false;
  row = number % 1'000;
  const std::uint32_t part = number / 1'000 % 10;
  if (row < 1 || row > 32 || (part != 0 && part != 8)) return false;
  column.wear = part == 8;
  const std::uint32_t which = number / 10'000;
  column.is_axis = which < 9;
  column.axis = which - 1;
  return !column.is_axis || column.axis < axes;
}

double& cell_of(interp::ToolOffset& tool, const OffsetColumn& column) {
  if (column.is_axis) return column.wear ? tool.wear[column.axis] : tool.geometry[column.axis];
  return column.wear ? tool.radius_wear : tool.radius;
}

// #5001… end of the block before, #5011… machine coordinates as their page shows them, #5041… absolute
// position now, and where a skip ended, #5081… offset in force: of the axis that the last digit counts
// from 1. @return whether it is one.
bool read_of_axis(const Executor& ex, std::uint32_t number, Value& value) {
  const std::size_t axis = number % 10 - std::size_t{1};
  if (number % 10 == 0 || axis >= ex.axes.size()) return false;
  const auto known = [&value](double is) {
    value = Value::of_double(is);
    return true;
  };
  switch (number / 10) {
    case 500:
    case 504:
      return known(ex.work_now[axis]);
    case 501:
      return known(ex.machine_now[axis] / ex.axes[axis].diameter);
    case 508: {
      const auto offset = static_cast<std::size_t>(ex.modal.offset);
      const auto& tools = ex.data.tools;
      const bool there = ex.modal.offset > 0 && offset < tools.size();
      return known(there ? tools[offset].geometry[axis] + tools[offset].wear[axis] : 0);
    }
    default:
      return false;
  }
}

}  // namespace

Error Language::read_system(std::uint32_t number, Value& value) {
  OffsetColumn column;
  std::size_t row = 0;
  if (offset_column(number, ex_.axes.size(), column, row)) {
    auto& tools = ex_.data.tools;
    value = Value::of_double(row < tools.size() ? cell_of(tools[row], column) : 0);
    return Error::none;
  }
  if (number >= 4'001 && number <= 4'016 && number != 4'008) {
    const std::int16_t tenths = ex_.modal.g[number - 4'000];
    if (tenths < 0) return Error::no_variable;  // this G-code system has no such group
    value = tenths % 10 == 0 ? Value::of_int(tenths / 10) : Value::of_double(tenths / 10.0);
    return Error::none;
  }
  if (read_of_axis(ex_, number, value)) return Error::none;
  switch (number) {
    case 4'105:
      value = Value::of_double(ex_.modal.feed);
      return Error::none;
    case 4'111:
      value = Value::of_int(ex_.block.has('L') ? ex_.block['L'].integer() : 0);
      return Error::none;
    case 4'112:
      value = Value::of_int(last_m);
      return Error::none;
    case 4'113:
      value = Value::of_int(ex_.at.sequence);
      return Error::none;
    case 4'114:
      value = Value::of_int(ex_.at.program);
      return Error::none;
    case 4'118:
      value = Value::of_double(ex_.modal.spindle_speed);
      return Error::none;
    case 4'119:
      value = Value::of_int(ex_.modal.tool * 100 + ex_.modal.offset);
      return Error::none;
    case 5'080: {
      const auto offset = static_cast<std::size_t>(ex_.modal.offset);
      const bool known = ex_.modal.offset > 0 && offset < ex_.data.tools.size();
      value =
          Value::of_double(known ? ex_.data.tools[offset].radius + ex_.data.tools[offset].radius_wear : 0);
      return Error::none;
    }
    default:
      break;
  }
  return machine_variable(number, value);
}

Error Language::write_system(std::uint32_t number, const Value& value) {
  if (value.is_null()) return Error::null_used;
  OffsetColumn column;
  std::size_t row = 0;
  if (!offset_column(number, ex_.axes.size(), column, row)) return set_machine_variable(number, value);
  auto& tools = ex_.data.tools;
  if (tools.size() <= row) tools.resize(row + 1);
  double& cell = cell_of(tools[row], column);
  const double before = cell;
  cell = value.number();
  if (cell != before) {
    std::string what = "tool/" + std::to_string(row);
    if (column.is_axis) {
      what += column.wear ? "/wear/" : "/geometry/";
      what += ex_.axes[column.axis].name;
    } else {
      what += column.wear ? "/radius_wear" : "/radius";
    }
    ex_.report_change(what, before, cell);
  }
  return Error::none;
}

}  // namespace headstock::dialects::k2000tc
