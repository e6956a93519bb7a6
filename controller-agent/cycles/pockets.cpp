// G71/G72 type II. A level cuts the profile into stretches that lie below it; inside such a stretch the next
// level makes smaller ones: a tree of pockets, walked depth first, so that a pocket is finished before the
// next one begins. Between the cuts the contour itself is followed from one level to the next, so nothing is
// left but the allowance. The tool moves rapidly only above levels that have been cleared over the whole
// stretch it moves in.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cycles/roughing.hpp"

namespace headstock::cycles {
namespace {

struct Pocket {
  Stretch range;  ///< of the profile; cleared down to `level`
  std::int64_t level = 0;
  std::vector<Stretch> children;  ///< its parts below the next level
  std::size_t next = 0;           ///< child to cut
};

// The tool on its way through one job; makes lists of moves that the coroutine hands on.
class Cutter {
 public:
  explicit Cutter(const Roughing& job) : job_(job), view_(view_of(job)) {
    for (const Segment& s : job.profile) profile_.push_back(view_.to(s));
    const Point by = view_.to(job.allowance);
    profile_ = shifted(profile_, by);
    start_ = view_.to(job.start);
    cleared_ = {start_.u + by.u, start_.v + by.v};
    here_ = start_;
  }

  double level(std::int64_t k) const { return cleared_.v - job_.depth * static_cast<double>(k); }
  double end() const { return static_cast<double>(profile_.size()); }
  Pocket pocket(Stretch range, std::int64_t k) const {
    return {range, k, not_above(profile_, level(k + 1), range), 0};
  }

  // Over cleared ground to a place of the contour.
  void approach(double place, std::int64_t parent_level) {
    const Point target = point_at(profile_, place);
    if (std::hypot(target.u - here_.u, target.v - here_.v) < kTiny) return;
    over(target.u, parent_level);
    const bool open = place == 0 && job_.approach_rapid;
    if (open) {
      rapid_v(target.v);
    } else {
      feed_v(target.v);
    }
  }
  // To the level of a cut where the stretch is open toward the start.
  void infeed(double to) {
    if (job_.approach_rapid) {
      rapid_v(to);
    } else {
      feed_v(to);
    }
  }
  void follow(Stretch stretch) {
    for (const Segment& s : cut_out(profile_, stretch)) emit(along(s));
  }
  void cut_to(double place) {
    const double u = point_at(profile_, place).u;
    if (u - here_.u > kTiny) emit(move_u(MoveKind::feed, u));
  }
  // At 45° over the ground just cut, or straight up when a ridge stands there.
  void leave(double left_place) {
    const double room = here_.u - point_at(profile_, left_place).u;
    double out = std::clamp(room, 0.0, job_.retract);
    for (const Segment& s : profile_) {
      const auto u = range_u(s);
      if (u[1] > here_.u - out && u[0] < here_.u && range_v(s)[1] > here_.v + kTiny) out = 0;
    }
    if (job_.retract > kTiny)
      emit(ending_pass(move_both(MoveKind::feed, {here_.u - out, here_.v + job_.retract})));
  }

  void cut(const Pocket& parent, std::size_t index) {
    const Stretch child = parent.children[index];
    const std::int64_t k = parent.level + 1;
    const double from = index == 0 ? parent.range.from : parent.children[index - 1].to;
    if (child.from <= from) {  // open at its start: nothing to follow down
      const Point target = point_at(profile_, child.from);
      over(target.u, parent.level);
      infeed(level(k));
    } else {
      approach(from, parent.level);
      follow({from, child.from});
    }
    cut_to(child.to);
    const bool last = index + 1 == parent.children.size();
    zone_ = k;
    if (last && job_.contour_out) {
      follow({child.to, parent.range.to});
      zone_ = parent.level;
    }
    leave(child.from);
  }
  // On the way out of a pocket whose cuts did not follow the contour.
  void cut_exit(const Pocket& parent) {
    const Stretch last{parent.children.back().to, parent.range.to};
    if (last.to <= last.from) return;
    approach(last.from, parent.level);
    follow(last);
    zone_ = parent.level;
    leave(parent.range.from);
  }
  void cut_bottom(const Pocket& leaf) {
    approach(leaf.range.from, leaf.level);
    follow(leaf.range);
    zone_ = leaf.level;
    leave(leaf.range.from);
  }
  void begin() { emit(move_both(MoveKind::rapid, cleared_)); }
  void finish() {
    const double lift = std::max(cleared_.v, here_.v);
    if (job_.contour_pass) {
      rapid_v(lift);
      rapid_u(profile_.front().from.u);
      infeed(profile_.front().from.v);
      for (const Segment& s : profile_) {
        emit(along(s));
        if (s.dwell_s > 0) out_.push_back({.kind = MoveKind::dwell, .seconds = s.dwell_s});
      }
    }
    rapid_v(std::max(cleared_.v, here_.v));
    if (job_.return_by_allowance) emit(move_both(MoveKind::rapid, cleared_));
    emit(move_both(MoveKind::rapid, start_));
  }

  std::vector<Move> take() { return std::exchange(out_, {}); }

 private:
  // Rapidly along the cuts, above what is cleared both where the tool is and where it goes.
  void over(double u, std::int64_t parent_level) {
    if (std::fabs(u - here_.u) <= kTiny) return;
    const double height = level(std::min(zone_, parent_level)) + job_.retract;
    if (here_.v < height - kTiny) rapid_v(height);
    rapid_u(u);
  }
  void emit(const Move& seen) {
    if (seen.along_u) here_.u = seen.to.u;
    if (seen.along_v) here_.v = seen.to.v;
    out_.push_back(back(view_, seen));
  }
  void rapid_u(double u) {
    if (std::fabs(u - here_.u) > kTiny) emit(move_u(MoveKind::rapid, u));
  }
  void rapid_v(double v) {
    if (std::fabs(v - here_.v) > kTiny) emit(move_v(MoveKind::rapid, v));
  }
  void feed_v(double v) {
    if (std::fabs(v - here_.v) > kTiny) emit(move_v(MoveKind::feed, v));
  }

  const Roughing& job_;
  View view_;
  Path profile_;
  Point start_, cleared_, here_;
  std::int64_t zone_ = 0;  ///< level down to which the stretch the tool is in has been cleared
  std::vector<Move> out_;
};

}  // namespace

Moves pocket_cuts(Roughing job) {
  Cutter tool(job);
  tool.begin();
  std::vector<Pocket> open;
  open.push_back(tool.pocket({0, tool.end()}, 0));
  while (!open.empty()) {
    Pocket& top = open.back();
    if (top.children.empty()) {
      tool.cut_bottom(top);
      open.pop_back();
    } else if (top.next < top.children.size()) {
      const std::size_t index = top.next++;
      tool.cut(top, index);
      open.push_back(tool.pocket(top.children[index], top.level + 1));
    } else {
      if (!job.contour_out) tool.cut_exit(top);
      open.pop_back();
    }
    for (const Move& move : tool.take()) co_yield move;
  }
  tool.finish();
  for (const Move& move : tool.take()) co_yield move;
}

}  // namespace headstock::cycles
