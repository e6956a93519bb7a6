// `headstock plot`: a program's path as a picture (SVG): rapid moves dashed, cuts solid, threads and taps in
// colours of their own. Lathes are drawn in the ZX plane with X as a radius, mills in XY unless told
// otherwise.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numbers>

#include "offline/offline.hpp"
#include "offline/session.hpp"
#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

constexpr std::size_t kMostMoves = 2'000'000;

struct Request {
  Options options;
  std::string file, out, plane;
  double width = 900;
};

struct Dot {
  double across = 0, up = 0;
};

struct Stroke {
  const char* kind;  ///< class of the style sheet
  std::vector<Dot> dots;
};

struct Picture {
  std::vector<Stroke> strokes;
  Dot low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
  std::string alarm;

  void see(Dot d) {
    low = {std::min(low.across, d.across), std::min(low.up, d.up)};
    high = {std::max(high.across, d.across), std::max(high.up, d.up)};
  }
};

class Pen {
 public:
  Pen(Picture& picture, std::size_t across, std::size_t up) : picture_(picture), across_(across), up_(up) {}

  void draw(const interp::Operation& operation) {
    std::visit(
        [this](const auto& op) {
          using T = std::decay_t<decltype(op)>;
          if constexpr (std::is_base_of_v<interp::Motion, T>) {
            const Dot to = dot(op.end_machine, op);
            if (!begun_) here_ = to;
            std::vector<Dot> dots{here_};
            if constexpr (std::is_same_v<T, interp::Arc>) bend(op, dots);
            if constexpr (std::is_same_v<T, interp::Tap>) dots.push_back(dot(op.bottom_machine, op));
            dots.push_back(to);
            if (begun_) add(kind_of(op), std::move(dots));
            here_ = to;
            begun_ = true;
          } else if constexpr (std::is_same_v<T, interp::Alarm>) {
            picture_.alarm = op.code;
          }
        },
        operation);
  }

 private:
  template <typename T>
  static const char* kind_of(const T& op) {
    if constexpr (std::is_same_v<T, interp::Rapid>) return "rapid";
    if constexpr (std::is_same_v<T, interp::Thread> || std::is_same_v<T, interp::Tap>) return "thread";
    return op.cycle != nullptr && std::string_view(op.cycle) == "G70" ? "finish" : "feed";
  }
  Dot dot(const interp::AxisVector& machine, const interp::Motion& motion) const {
    return {machine[across_] - motion.modal.work_zero[across_], machine[up_] - motion.modal.work_zero[up_]};
  }
  // Chords of 3°; an arc outside the drawn plane is seen from its edge and stays its chord.
  void bend(const interp::Arc& arc, std::vector<Dot>& dots) const {
    const Dot center = dot(arc.center_machine, arc);
    const Dot to = dot(arc.end_machine, arc);
    const double a = std::atan2(here_.up - center.up, here_.across - center.across);
    const double r0 = std::hypot(here_.up - center.up, here_.across - center.across);
    const double r1 = std::hypot(to.up - center.up, to.across - center.across);
    const bool in_plane = arc.plane == interp::Plane::zx ? up_ < across_ : across_ < up_;
    if (!in_plane || std::fabs(r0 - arc.radius_mm) > 0.1) return;
    const double sweep = arc.turns * 2 * std::numbers::pi * (arc.turn == interp::Turn::ccw ? 1 : -1);
    const int chords = std::max(1, static_cast<int>(std::fabs(sweep) * 60 / std::numbers::pi));
    for (int i = 1; i < chords; ++i) {
      const double t = static_cast<double>(i) / chords;
      const double r = r0 + (r1 - r0) * t;
      dots.push_back({center.across + r * std::cos(a + sweep * t), center.up + r * std::sin(a + sweep * t)});
    }
  }
  void add(const char* kind, std::vector<Dot> dots) {
    for (const Dot& d : dots) picture_.see(d);
    if (!picture_.strokes.empty() && picture_.strokes.back().kind == kind) {
      auto& last = picture_.strokes.back().dots;
      last.insert(last.end(), dots.begin() + 1, dots.end());
    } else {
      picture_.strokes.push_back({kind, std::move(dots)});
    }
  }

  Picture& picture_;
  std::size_t across_, up_;
  Dot here_;
  bool begun_ = false;
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value + 0.0);
  return text;
}

std::string svg(const Picture& picture, double width, char across, char up) {
  const double span =
      std::max({picture.high.across - picture.low.across, picture.high.up - picture.low.up, 1.0});
  const double margin = 0.05 * span;
  const double scale = width / (picture.high.across - picture.low.across + 2 * margin);
  const double height = (picture.high.up - picture.low.up + 2 * margin) * scale;
  const auto x = [&](double v) { return number((v - picture.low.across + margin) * scale); };
  const auto y = [&](double v) { return number((picture.high.up + margin - v) * scale); };
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + ' ' +
                    number(height) +
                    "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                    "<style>path{fill:none;stroke-width:1.2}.rapid{stroke:#9a9a9a;stroke-dasharray:5 3;"
                    "stroke-width:.8}.feed{stroke:#1f5fbf}.finish{stroke:#c02020;stroke-width:1.8}"
                    ".thread{stroke:#b06a00}.axis{stroke:#ddd}text{fill:#555}</style>\n"
                    "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  // The work zero's lines, where they are in sight.
  if (picture.low.up - margin < 0 && picture.high.up + margin > 0)
    out += "<path class=\"axis\" d=\"M0 " + y(0) + 'H' + number(width) + "\"/>\n";
  if (picture.low.across - margin < 0 && picture.high.across + margin > 0)
    out += "<path class=\"axis\" d=\"M" + x(0) + " 0V" + number(height) + "\"/>\n";
  for (const Stroke& stroke : picture.strokes) {
    out += std::string("<path class=\"") + stroke.kind + "\" d=\"";
    char command = 'M';
    for (const Dot& d : stroke.dots) {
      out += command;
      out += x(d.across) + ' ' + y(d.up);
      command = 'L';
    }
    out += "\"/>\n";
  }
  out += "<text x=\"4\" y=\"14\">" + std::string(1, up) + "</text><text x=\"" + number(width - 14) +
         "\" y=\"" + number(height - 5) + "\">" + std::string(1, across) + "</text>\n";
  if (!picture.alarm.empty())
    out += "<text x=\"20\" y=\"14\" style=\"fill:#c00\">" + picture.alarm + "</text>\n";
  return out + "</svg>\n";
}

int plot(const Request& request) {
  const auto wrong = [](const std::string& text) {
    std::cerr << "headstock plot: " << text << "\n";
    return 1;
  };
  std::string error;
  const auto session = make_session(request.options, error);
  if (!session) return wrong(error);
  auto source = open_program(request.file);
  if (source == nullptr) return wrong(request.file + ": cannot be read");
  if (request.file != "-") session->programs.add_file(request.file);
  std::string plane = request.plane;
  if (plane.empty()) plane = session->dialect->tools.lathe ? "ZX" : "XY";
  if (plane.size() != 2) return wrong("--plane is two axes: ZX, XY, YZ, XZ");
  const auto across = session->machine.axis_index(plane[0]);
  const auto up = session->machine.axis_index(plane[1]);
  if (!across || !up) return wrong("the machine has no axes " + plane);

  interp::Interpreter interpreter(*session->dialect, session->machine, session->data, &session->programs);
  interpreter.set_switches(session->switches);
  interpreter.start(std::move(source), session->start_position());
  Picture picture;
  Pen pen(picture, *across, *up);
  interp::Operation operation;
  std::size_t moves = 0;
  while (interpreter.next(operation) == interp::Pull::operation) {
    if (++moves > kMostMoves) return wrong("more than 2,000,000 operations: not a picture any more");
    pen.draw(operation);
  }
  if (picture.strokes.empty())
    return wrong("nothing moves" + (picture.alarm.empty() ? "" : ": alarm " + picture.alarm));
  const std::string text = svg(picture, request.width, plane[0], plane[1]);
  if (request.out.empty() || request.out == "-") {
    std::cout << text;
  } else {
    std::ofstream out(request.out, std::ios::binary);
    out << text;
    if (!out.flush()) return wrong(request.out + ": cannot be written");
  }
  return picture.alarm.empty() ? 0 : 2;
}

}  // namespace

void add_plot(options::Command app, int& exit_status) {
  const auto request = std::make_shared<Request>();
  auto command = app.add_command("plot", "Draw a program's path (SVG)");
  add_options(command, request->options);
  command.option("file", request->file, "Program, - for standard input").required();
  command.option("-o,--out", request->out, "Picture, - for standard output (the default)");
  command.option("--plane", request->plane, "Axes across and up: ZX (lathes), XY (mills), XZ, YZ");
  command.option("--width", request->width, "Width of the picture in pixels").between(100.0, 10'000.0);
  command.callback([request, &exit_status] { exit_status = plot(*request); });
}

}  // namespace headstock::offline
