// The same work written in another way: mirrored to the other side of the axis, along +Z, in inches, by
// increments, with variables. Whatever a cycle makes of it must be the same moves, mirrored where the work
// is. Every cycle of turning on the four lathes that have it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::interp {
namespace {

constexpr double kGrid_mm = 0.254;     // a hundredth of an inch: exact in both units
constexpr double kMetric_mm = 0.0015;  // levels are rounded to the least increment,
constexpr double kInch_mm = 0.006;     // of 0.0001 inch, twice
constexpr const char* kLathes[] = {"fanuc-0i-t", "gsk-2000tc", "gsk-218t", "k2000tc"};

struct Way {
  const char* name;
  double x = 1, z = 1;  ///< -1: mirrored
  bool inch = false, incremental = false, variables = false;
};
constexpr Way kAsDrawn{"as drawn"};
constexpr Way kWays[] = {{"below the axis", -1, 1},
                         {"toward +Z", 1, -1},
                         {"both", -1, -1},
                         {"inch", 1, 1, true},
                         {"inch below the axis", -1, 1, true},
                         {"incremental", 1, 1, false, true},
                         {"incremental below the axis", -1, 1, false, true},
                         {"variables", 1, 1, false, false, true}};

struct Xz {
  double x = 0, z = 0;  ///< x by radius
};
struct Element {
  Xz to;
  int turn = 0;  ///< 0 line, +1 G03, -1 G02
  double radius = 0;
};
struct TurningJob {
  std::string code;
  Xz start, end;
  Xz first;                       ///< of a profile
  std::vector<Element> profile;   ///< G71-G73
  double depth = 0, retract = 0;  ///< also of G74, G75
  Xz allowance, relief;
  int passes = 2;
  double taper = 0;
  Xz step;  ///< P, Q of G74, G75
  double height = 0, first_depth = 0;
  double nose = 0;  ///< radius of the tool's nose, of a profile cut under G41 or G42; 0: G40
};

struct Random {
  std::mt19937 engine;
  double grid(double low, double high) {
    const auto n = static_cast<double>(engine()) / 4294967296.0;
    return std::round((low + n * (high - low)) / kGrid_mm) * kGrid_mm;
  }
  int pick(int count) { return static_cast<int>(engine() % static_cast<unsigned>(count)); }
};

TurningJob random_turning(Random& random) {
  constexpr const char* kCodes[] = {"G71", "G72", "G73", "G90", "G92", "G94", "G74", "G75", "G76"};
  TurningJob job;
  job.code = kCodes[random.pick(9)];
  job.retract = random.grid(0.3, 0.9);
  job.start = {random.grid(30, 35), random.grid(1, 4)};
  job.end = {random.grid(20, 27), random.grid(-30, -10)};
  const double tapers[] = {0, random.grid(-3, -1), random.grid(0.3, 1)};
  job.taper = tapers[random.pick(3)];
  job.step = {random.grid(1, 4), random.grid(1, 4)};
  job.height = random.grid(1, 2.5);
  job.first_depth = random.grid(0.4, 0.9);
  if (job.code == "G94") job.end = {random.grid(5, 12), random.grid(-8, -4)};
  if (job.code == "G74" || job.code == "G75") job.end.x = random.grid(5, 15);
  if (job.code > "G73") return job;

  Xz at{random.grid(5, 15), random.grid(-3, 3)};
  std::vector<Xz> corners{at};
  const int count = 1 + random.pick(6);
  for (int i = 0; i < count; ++i) {
    double up = random.grid(0.6, 6), along = random.grid(0.6, 8);
    const int kind = random.pick(4);
    if (kind == 0 && i > 0) along = 0;
    if (kind == 1 && i + 1 < count) up = 0;
    Element e;
    if (kind > 1 && random.pick(2) == 0) {  // a quarter circle
      along = up;
      e.turn = random.pick(2) == 0 ? 1 : -1;
      e.radius = up;
    }
    at = {at.x + up, at.z - along};
    e.to = at;
    corners.push_back(at);
    job.profile.push_back(e);
  }
  job.start = {at.x + random.grid(0.8, 4), corners.front().z + random.grid(0.8, 3)};
  job.first = corners.front();
  if (job.code == "G72") {  // from its other end
    std::vector<Element> back;
    for (std::size_t i = job.profile.size(); i-- > 0;)
      back.push_back({corners[i], -job.profile[i].turn, job.profile[i].radius});
    job.profile = back;
    job.first = at;
  }
  job.depth = random.grid(0.6, 3);
  job.allowance = {random.pick(2) * kGrid_mm, random.pick(2) * kGrid_mm};
  job.relief = {random.grid(1, 4), random.grid(0, 2)};
  job.passes = 2 + random.pick(3);
  if (random.pick(2) == 0) job.nose = random.grid(0.4, 1);
  return job;
}

class Writer {
 public:
  Writer(const Way& way, std::string profile) : way_(way), profile_(std::move(profile)) {}
  std::string program(const TurningJob& job) {
    text_ = std::string("O0001\nM03 S300\nG98\n") + (way_.inch ? "G20\n" : "G21\n");
    if (job.nose > 0) line("T0101\n" + side(job));
    line("G00 " + x(job.start.x) + ' ' + z(job.start.z));
    if (!job.profile.empty()) {
      stock_removal(job);
      if (job.nose > 0) line("G40 G00 " + x(job.start.x + 10) + ' ' + z(job.start.z + 10));
    } else if (job.code == "G74" || job.code == "G75") {
      line(job.code + " R" + number(job.retract));
      line(job.code + ' ' + x(job.end.x) + ' ' + z(job.end.z) + " P" + count(job.step.x) + " Q" +
           count(job.step.z) + feed());
    } else if (job.code == "G76") {
      line("G76 P020560 Q" + count(kGrid_mm) + " R" + number(kGrid_mm));
      line("G76 " + x(job.end.x) + ' ' + z(job.end.z) + taper(job, way_.x) + " P" + count(job.height) + " Q" +
           count(job.first_depth) + lead());
    } else {
      const bool facing = job.code == "G94";
      line(job.code + ' ' + x(job.end.x) + ' ' + z(job.end.z) + taper(job, facing ? way_.z : way_.x) +
           (job.code == "G92" ? lead() : feed()));
      line(facing ? z(job.end.z - 3 * kGrid_mm) : x(job.end.x - 3 * kGrid_mm));
    }
    return text_ + "M30\n";
  }

 private:
  void line(const std::string& block) { text_ += block + '\n'; }
  std::string number(double mm) const {
    char text[40];
    std::snprintf(text, sizeof text, way_.inch ? "%.4f" : "%.3f", way_.inch ? mm / 25.4 : mm);
    return text;
  }
  std::string x(double radius) const { return 'X' + number(2 * radius * way_.x); }
  std::string z(double mm) const { return 'Z' + number(mm * way_.z); }
  // Outside, toward the chuck, the tool is right of the contour; G72 runs it the other way, a mirror turns it
  // round.
  std::string side(const TurningJob& job) const {
    const bool right = (job.code == "G72") == (way_.x * way_.z < 0);
    return right ? "G42" : "G41";
  }
  // P and Q: least increments, lengths on the 218T.
  std::string count(double mm) const {
    if (profile_ == "gsk-218t") return number(mm);
    return std::to_string(std::lround(way_.inch ? mm / 25.4 * 10'000 : mm * 1'000));
  }
  std::string feed() const { return " F" + number(203.2); }
  std::string lead() const { return " F" + number(2.54); }
  std::string taper(const TurningJob& job, double sign) const {
    return job.taper == 0 ? "" : " R" + number(job.taper * sign);
  }
  std::string allowance(const TurningJob& job) const {
    return " U" + number(2 * job.allowance.x * way_.x) + " W" + number(job.allowance.z * way_.z);
  }
  void stock_removal(const TurningJob& job) {
    const std::string& code = job.code;
    if (code == "G73") {
      line("G73 U" + number(job.relief.x * way_.x) + " W" + number(job.relief.z * way_.z) + " R" +
           std::to_string(job.passes));
    } else {
      line(code + (code == "G71" ? " U" : " W") + number(job.depth) + " R" + number(job.retract));
    }
    line(code + " P10 Q20" + allowance(job) + feed());
    if (code == "G73") line("N10 G00 " + x(job.first.x) + ' ' + z(job.first.z));
    if (code == "G71") line("N10 G00 " + x(job.first.x) + "\nG01 " + z(job.first.z));
    if (code == "G72") line("N10 G00 " + z(job.first.z) + "\nG01 " + x(job.first.x));
    Xz at = job.first;
    for (std::size_t i = 0; i < job.profile.size(); ++i) {
      const Element& e = job.profile[i];
      std::string words = x(e.to.x) + ' ' + z(e.to.z);
      if (way_.incremental)
        words = 'U' + number(2 * (e.to.x - at.x) * way_.x) + " W" + number((e.to.z - at.z) * way_.z);
      if (way_.variables) {
        line("#101=" + number(2 * e.to.x * way_.x));
        words = "X#101 " + z(e.to.z);
      }
      const double turn = e.turn * way_.x * way_.z;
      const std::string g = turn == 0 ? "G01 " : turn > 0 ? "G03 " : "G02 ";
      line((i + 1 == job.profile.size() ? "N20 " : "") + g + words +
           (e.turn == 0 ? "" : " R" + number(e.radius)));
      at = e.to;
    }
    line("G70 P10 Q20");
  }

  const Way& way_;
  std::string profile_, text_;
};

struct Made {
  std::size_t kind = 0;  ///< Operation::index()
  Xz to;
  int turn = 0;
  double radius = 0;
};
struct Moves {
  std::vector<Made> made;
  std::string alarm;
};

// The imaginary tip that lies as number 3 does, in the mirrored work.
std::uint8_t tip_of(const Way& way) {
  if (way.x > 0) return way.z > 0 ? 3 : 4;
  return way.z > 0 ? 2 : 1;
}

constexpr double kNoMove_mm = 0.01;  // what rounding makes of nothing, in inches

Moves moves_of(const std::string& profile, const std::string& program, double nose, std::uint8_t tip) {
  const machine::Machine machine = *machine::default_machine(profile);
  std::size_t x = 0, z = 1;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    if (machine.axes[i].name == 'X') x = i;
    if (machine.axes[i].name == 'Z') z = i;
  }
  MachineData data;
  data.parameters["P0042"] = 3;  // K2000TC: the code system of turning
  data.tools.resize(2);
  data.tools[1].radius = nose;
  data.tools[1].tip = tip;
  Interpreter interpreter(*dialects::find(profile), machine, data, nullptr);
  interpreter.start(program::source_from_text(program), {});
  Moves result;
  Xz at;
  Operation op;
  while (interpreter.next(op) == Pull::operation) {
    if (const auto* alarm = std::get_if<Alarm>(&op)) result.alarm = alarm->code + ' ' + alarm->detail;
    Made made;
    made.kind = op.index();
    const auto take = [&](const Motion& motion) {
      made.to = {motion.end_machine[x], motion.end_machine[z]};
      if (std::hypot(made.to.x - at.x, made.to.z - at.z) > kNoMove_mm) result.made.push_back(made);
      at = made.to;
    };
    if (const auto* rapid = std::get_if<Rapid>(&op)) take(*rapid);
    if (const auto* feed = std::get_if<Feed>(&op)) take(*feed);
    if (const auto* thread = std::get_if<Thread>(&op)) take(*thread);
    if (const auto* arc = std::get_if<Arc>(&op)) {
      made.turn = arc->turn == Turn::ccw ? 1 : -1;
      made.radius = arc->radius_mm;
      take(*arc);
    }
  }
  return result;
}

// Whether a level of the roughing just touches a corner: one cut over it or none are the same, and rounding
// decides.
bool level_on_corner(const TurningJob& job) {
  if (job.code != "G71" && job.code != "G72") return false;
  const auto touches = [&](Xz corner) {
    const bool facing = job.code == "G72";
    const double away = facing ? job.start.z - corner.z : job.start.x - corner.x;
    for (const double by : {0.0, facing ? job.allowance.z : job.allowance.x}) {
      if (std::fabs(std::remainder(away - by, job.depth)) < 0.02) return true;
    }
    return false;
  };
  bool any = touches(job.first);
  for (const Element& e : job.profile) any = any || touches(e.to);
  return any;
}

TEST(CycleVariants, TheSameWorkMakesTheSameMoves) {
  Random random{std::mt19937(4)};
  std::size_t compared = 0, compensated = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    const TurningJob job = random_turning(random);
    for (const char* profile : kLathes) {
      const std::string drawn = Writer(kAsDrawn, profile).program(job);
      SCOPED_TRACE(std::string(profile) + '\n' + drawn);
      const Moves expected = moves_of(profile, drawn, job.nose, tip_of(kAsDrawn));
      if (job.nose == 0) {
        ASSERT_EQ(expected.alarm, "");
      }
      if (job.nose > 0) (expected.alarm.empty() ? compensated : refused) += 1;
      for (const Way& way : kWays) {
        if ((way.incremental || way.variables) && job.profile.empty()) continue;
        if (way.variables && std::string_view(profile) == "gsk-218t") continue;  // G65 H only
        if (way.inch && level_on_corner(job)) continue;
        const std::string written = Writer(way, profile).program(job);
        SCOPED_TRACE(std::string(way.name) + '\n' + written);
        const Moves made = moves_of(profile, written, job.nose, tip_of(way));
        ASSERT_EQ(made.alarm, expected.alarm);  // a nose may have no room in the contour
        ASSERT_EQ(made.made.size(), expected.made.size());
        const double near = way.inch ? kInch_mm : kMetric_mm;
        for (std::size_t k = 0; k < made.made.size(); ++k) {
          const Made &a = expected.made[k], &b = made.made[k];
          ASSERT_EQ(a.kind, b.kind) << "move " << k;
          ASSERT_NEAR(a.to.x * way.x, b.to.x, near) << "move " << k;
          ASSERT_NEAR(a.to.z * way.z, b.to.z, near) << "move " << k;
          ASSERT_EQ(a.turn * way.x * way.z, b.turn) << "move " << k;
          ASSERT_NEAR(a.radius, b.radius, 2 * near) << "move " << k;
        }
        compared += made.made.size();
      }
    }
  }
  std::printf("moves compared %zu; under G41 or G42 %zu programs, %zu with an alarm\n", compared, compensated,
              refused);
  EXPECT_GT(compared, 100'000u);
  EXPECT_GT(compensated, 50u);
}

}  // namespace
}  // namespace headstock::interp
