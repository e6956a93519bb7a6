#include "offline/json_lines.hpp"

#include <charconv>
#include <cmath>
#include <type_traits>

#include "dialects/catalogue.hpp"

namespace headstock::offline {
namespace {

using interp::AxisVector;

// Nine decimals are far below any control's increment and hide the last bits of sums.
void number(std::string& out, double value) {
  const double rounded = std::round(value * 1e9) / 1e9;
  char text[32];
  const auto end =
      std::to_chars(text, text + sizeof text, (std::fabs(value) < 1e6 ? rounded : value) + 0.0).ptr;
  out.append(text, end);
}

void integer(std::string& out, std::int64_t value) {
  char text[24];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

void text(std::string& out, std::string_view value) {
  out += '"';
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte >= 0x7f) {  // bytes of unknown encodings stay visible and the line valid
      constexpr char kHex[] = "0123456789abcdef";
      out += "\\u00";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    } else {
      out += c;
    }
  }
  out += '"';
}

void key(std::string& out, std::string_view name) {
  out += ",\"";
  out += name;
  out += "\":";
}

class Record {
 public:
  Record(std::string& out, const machine::Machine& machine) : out_(out), machine_(machine) {}

  void begin(std::string_view op, const interp::SourcePosition& at) {
    out_ += "{\"op\":\"";
    out_ += op;
    out_ += "\",\"line\":";
    integer(out_, at.line);
    key(out_, "program");
    if (at.program == 0) {
      out_ += "\"\"";
    } else {
      out_ += "\"O";
      if (at.program < 1000) out_.append(at.program < 10 ? 3 : at.program < 100 ? 2 : 1, '0');
      integer(out_, at.program);
      out_ += '"';
    }
    if (at.sequence != 0) {
      key(out_, "n");
      integer(out_, at.sequence);
    }
  }
  void end() { out_ += "}\n"; }

  void axes(std::string_view name, const AxisVector& values, std::uint32_t which) {
    key(out_, name);
    char separator = '{';
    for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
      if ((which >> i & 1u) == 0) continue;
      out_ += separator;
      out_ += '"';
      out_ += machine_.axes[i].name;
      out_ += "\":";
      number(out_, values[i]);
      separator = ',';
    }
    if (separator == '{') out_ += '{';
    out_ += '}';
  }
  void value(std::string_view name, double v) {
    key(out_, name);
    number(out_, v);
  }
  void count(std::string_view name, std::int64_t v) {
    key(out_, name);
    integer(out_, v);
  }
  void word(std::string_view name, std::string_view v) {
    key(out_, name);
    text(out_, v);
  }
  void truth(std::string_view name, bool v) {
    key(out_, name);
    out_ += v ? "true" : "false";
  }

  void motion(std::string_view op, const interp::Motion& m) {
    constexpr std::uint32_t kAll = 0xff;
    begin(op, m.at);
    axes("end", m.end_work, kAll);
    axes("machine", m.end_machine, kAll);
    if (m.cycle != nullptr) word("cycle", m.cycle);
    if (m.exact_stop) truth("exact_stop", true);
  }
  void feed(double value_of, interp::FeedUnit unit) {
    value(unit == interp::FeedUnit::mm_per_revolution ? "fr"
          : unit == interp::FeedUnit::inverse_time    ? "fi"
                                                      : "f",
          value_of);
  }

 private:
  std::string& out_;
  const machine::Machine& machine_;
};

struct PlaneNames {
  std::string_view name;
  char first, second;
};
constexpr PlaneNames kPlanes[] = {{"XY", 'X', 'Y'}, {"ZX", 'Z', 'X'}, {"YZ", 'Y', 'Z'}};

}  // namespace

void JsonLines::append(const interp::Operation& operation, std::string& out) const {
  Record r(out, machine_);
  std::visit(
      [&](const auto& op) {
        using T = std::decay_t<decltype(op)>;
        if constexpr (std::is_same_v<T, interp::Rapid>) {
          r.motion("rapid", op);
        } else if constexpr (std::is_same_v<T, interp::Feed>) {
          r.motion("feed", op);
          r.feed(op.feed, op.unit);
          if (op.skip_signals != 0) r.count("skip", op.skip_signals);
        } else if constexpr (std::is_same_v<T, interp::Arc>) {
          r.motion("arc", op);
          r.feed(op.feed, op.unit);
          const PlaneNames& plane = kPlanes[static_cast<std::size_t>(op.plane)];
          r.word("plane", plane.name);
          r.word("dir", op.turn == interp::Turn::cw ? "cw" : "ccw");
          std::uint32_t in_plane = 0;
          if (op.axis_1 != interp::Arc::kByPlane) in_plane = 1u << op.axis_1 | 1u << op.axis_2;
          for (const char name : {plane.first, plane.second}) {
            if (op.axis_1 != interp::Arc::kByPlane) break;
            if (const auto axis = machine_.axis_index(name)) in_plane |= 1u << *axis;
          }
          r.axes("center", op.center_work, in_plane);
          r.value("radius", op.radius_mm);
          r.value("turns", op.turns);
        } else if constexpr (std::is_same_v<T, interp::Thread>) {
          r.motion("thread", op);
          r.value("lead", op.lead_mm);
          if (op.lead_change_mm != 0) r.value("lead_change", op.lead_change_mm);
          if (op.start_angle_deg != 0) r.value("angle", op.start_angle_deg);
        } else if constexpr (std::is_same_v<T, interp::Tap>) {
          r.motion("tap", op);
          r.axes("bottom", op.bottom_work, 0xff);
          r.value("pitch", op.pitch_mm);
          r.value("rpm", op.rpm);
          r.word("dir", op.direction == interp::SpindleDirection::ccw ? "ccw" : "cw");
          if (op.kind == interp::TapKind::follows) r.truth("follows", true);
          if (op.dwell_s != 0) r.value("s", op.dwell_s);
        } else if constexpr (std::is_same_v<T, interp::Dwell>) {
          r.begin("dwell", op.at);
          r.value("s", op.seconds);
          if (op.revolutions != 0) r.value("rev", op.revolutions);
        } else if constexpr (std::is_same_v<T, interp::Spindle>) {
          r.begin("spindle", op.at);
          constexpr std::string_view kDirections[] = {"stop", "cw", "ccw"};
          r.word("dir", kDirections[static_cast<std::size_t>(op.direction)]);
          r.value(op.constant_surface_speed ? "m_min" : "rpm", op.speed);
          if (op.clamp_rpm != 0) r.value("clamp", op.clamp_rpm);
          if (op.gear != 0) r.count("gear", op.gear);
        } else if constexpr (std::is_same_v<T, interp::Tool>) {
          r.begin("tool", op.at);
          r.count("tool", op.tool);
          r.count("offset", op.offset);
        } else if constexpr (std::is_same_v<T, interp::MCode>) {
          r.begin("m", op.at);
          r.count("code", op.code);
          if (op.after_motion) r.truth("after_motion", true);
          if (op.delay_s != 0) r.value("delay", op.delay_s);
          if (op.at_axis >= 0) {
            r.count("at_axis", op.at_axis);
            r.value("at", op.at_position);
          }
          if (op.input != 0) {
            r.count("input", op.input);
            r.truth("input_level", op.input_level);
          }
          if (op.counts_part) r.truth("counts_part", true);
          if (op.clears_parts) r.truth("clears_parts", true);
        } else if constexpr (std::is_same_v<T, interp::Message>) {
          r.begin("message", op.at);
          r.word("text", op.text);
        } else if constexpr (std::is_same_v<T, interp::Stop>) {
          r.begin("stop", op.at);
          r.truth("optional", op.optional);
        } else if constexpr (std::is_same_v<T, interp::Alarm>) {
          r.begin("alarm", op.at);
          r.word("code", op.code);
          r.word("text", dialects::alarm_text(profile_, op.code).en);
          if (!op.detail.empty()) r.word("detail", op.detail);
          r.count("column", op.at.column);
        } else if constexpr (std::is_same_v<T, interp::ContourMode>) {
          r.begin("contour_mode", op.at);
          r.truth("on", op.on);
          if (op.level != 0) r.count("level", op.level);
          if (op.reference_feed != 0) r.value("f", op.reference_feed);
        } else if constexpr (std::is_same_v<T, interp::StrokeCheck>) {
          r.begin("stroke_check", op.at);
          r.truth("on", op.on);
          if (op.axes != 0) {
            r.truth("outside", op.outside_forbidden);
            r.axes("most", op.most, op.axes);
            r.axes("least", op.least, op.axes);
          }
        } else if constexpr (std::is_same_v<T, interp::SpindleWatch>) {
          r.begin("spindle_watch", op.at);
          r.truth("on", op.on);
          if (op.on) {
            r.value("delay", op.delay_s);
            r.value("reached", op.reached_ratio);
            r.value("ratio", op.ratio);
            r.value("width", op.width_rpm);
          }
        } else if constexpr (std::is_same_v<T, interp::PolygonTurning>) {
          r.begin("polygon", op.at);
          r.truth("on", op.on);
          r.count("p", op.spindle_ratio);
          r.count("q", op.tool_ratio);
        } else if constexpr (std::is_same_v<T, interp::SecondAuxiliary>) {
          r.begin("aux", op.at);
          r.count("code", op.code);
        } else {
          r.begin("end", op.at);
          constexpr std::string_view kReasons[] = {"m02", "m30", "m99", "end_of_file", "alarm"};
          r.word("reason", kReasons[static_cast<std::size_t>(op.reason)]);
          r.truth("counts_part", op.counts_part);
        }
      },
      operation);
  r.end();
}

}  // namespace headstock::offline
