#include "cycles/thread_words.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headstock::cycles {
namespace {

using interp::Executor;

constexpr double kLeastRatio = 0.01, kMostRatio = 4;  // K2000TC: of J to K

bool take_lead(Executor& ex, const Rules& rules) {
  const program::Block& b = ex.block;
  const auto& threads = ex.dialect.threads;
  if (b.has('F') && b.has('I') && threads.f_and_i_is_alarm && threads.inch_word) {
    return ex.alarm(dialects::AlarmReason::thread_f_and_i, b['I'].column, "I");
  }
  if (b.has('F')) {
    const program::Word& word = b['F'];
    const auto& numbers = ex.dialect.numbers;
    ex.lead_mm = word.point || ex.pocket ? word.value() * ex.unit_mm
                 : ex.modal.inch         ? word.value() * numbers.feed_per_revolution_unit_inch * 25.4
                                         : word.value() * numbers.feed_per_revolution_unit_mm;
  } else if (b.has('I') && threads.inch_word) {
    const double per_inch = b['I'].value();
    ex.lead_mm = per_inch > 0 ? 25.4 / per_inch : 0;
  }
  if (!(ex.lead_mm > 0) || ex.lead_mm > threads.most_lead_mm) return fail(ex, rules, Fault::thread_lead, 'F');
  return true;
}

// J: across (radius), K: along; both without a sign; kept until the next cycle.
bool take_runout_words(Executor& ex, const Rules& rules, double lead, Runout& runout) {
  interp::BoxWords& words = ex.cycle.box;
  const program::Block& b = ex.block;
  if (b.has('J')) words.runout_short = std::fabs(ex.length_mm(b['J']));
  if (b.has('K')) words.runout_long = std::fabs(ex.length_mm(b['K']));
  const double standard = ex.data.parameter(rules.parameters.runout, rules.runout_default) * 0.1 * lead;
  const bool has_short = words.runout_short >= 0, has_long = words.runout_long >= 0;
  if (!has_short && !has_long) {
    runout = {standard, standard};
  } else if (!has_short) {
    runout = {words.runout_long, rules.half_runout_is_45 ? words.runout_long : standard};
  } else if (words.runout_short == 0 || (has_long && words.runout_long == 0 && rules.half_runout_is_45)) {
    runout = {};
  } else {
    const double along = has_long && words.runout_long > 0 ? words.runout_long : words.runout_short;
    runout = {along, words.runout_short};
  }
  return true;
}

// 200T: P where it begins in 0.1 lead, J how far across; K the run-in. Both P and J are needed for a run-out.
void take_position_words(Executor& ex, double lead, ThreadUse use, ThreadPass& job) {
  interp::BoxWords& words = ex.cycle.box;
  const program::Block& b = ex.block;
  if (use == ThreadUse::multiple) {
    words.runout_long = std::max(0.0, ex.cycle.runout_tenths) * 0.1 * lead;
  } else if (b.has('P')) {
    words.runout_long = std::fabs(b['P'].value()) * 0.1 * lead;
  }
  if (b.has('J')) words.runout_short = std::fabs(ex.length_mm(b['J']));
  if (b.has('K')) words.run_in = std::fabs(ex.length_mm(b['K']));
  if (words.runout_long > 0 && words.runout_short > 0) job.runout = {words.runout_long, words.runout_short};
  job.run_in = words.run_in;
}

}  // namespace

double count_length(const Executor& ex, const program::Word& word, double unit_mm) {
  if (unit_mm == 0 || word.point) return ex.length_mm(word);
  return word.value() * static_cast<double>(ex.linear_increment) / 1e9 * ex.unit_mm;
}

bool take_thread_words(Executor& ex, const Rules& rules, const PlaneAxes& axes, ThreadUse use,
                       ThreadPass& job) {
  const program::Block& b = ex.block;
  if (!take_lead(ex, rules)) return false;
  const double along_u = std::fabs(job.end.u - job.start.u);
  const double along_v = std::fabs(job.taper);
  const double longer = std::max(along_u, along_v);
  job.lead_mm = ex.lead_mm;
  ex.cycle.retreat_ratio = 1;
  if (ex.dialect.threads.lead_along_path && longer > 0) {
    job.lead_mm = ex.lead_mm * longer / std::hypot(along_u, along_v);
  }
  interp::BoxWords& words = ex.cycle.box;
  const bool starts_allowed =
      rules.starts_word && (rules.starts_parameter.empty() || ex.data.bit(rules.starts_parameter));
  if (b.has('L')) {
    if (!starts_allowed) return fail(ex, rules, Fault::value, 'L');
    const auto starts = static_cast<std::int64_t>(b['L'].value());
    if (starts < 0 || starts > 99 || static_cast<double>(starts) != b['L'].value()) {
      return fail(ex, rules, Fault::value, 'L');
    }
    words.starts = std::max<std::int64_t>(starts, 1);
  }
  job.starts = words.starts;
  if (use == ThreadUse::single && b.has('Q')) {
    if (!rules.angle_word) return fail(ex, rules, Fault::value, 'Q');
    job.angle_deg = b['Q'].point ? b['Q'].value() : b['Q'].value() * ex.dialect.threads.q_unit_deg;
    if (job.angle_deg < 0 || job.angle_deg > 360) return fail(ex, rules, Fault::value, 'Q');
  }
  switch (rules.runout_form) {
    case RunoutForm::parameter: {
      for (const char letter : {'J', 'K'}) {
        if (b.has(letter)) return fail(ex, rules, Fault::value, letter);
      }
      const double amount =
          ex.data.parameter(rules.parameters.runout, rules.runout_default) * 0.1 * ex.lead_mm;
      const double angle = std::clamp(ex.data.parameter(rules.parameters.runout_angle, 45), 1.0, 89.0);
      job.runout = {amount, amount * std::tan(angle * std::numbers::pi / 180)};
      break;
    }
    case RunoutForm::lengths:
      if (!take_runout_words(ex, rules, ex.lead_mm, job.runout)) return false;
      break;
    case RunoutForm::position:
      take_position_words(ex, ex.lead_mm, use, job);
      break;
    case RunoutForm::width: {  // K2000TC: P in 0.1 lead where the parameter allows it
      // J/K is a factor on the acceleration that takes the tool away from the thread (L12834).
      const auto share = [&](char letter) {
        return b.has(letter) ? static_cast<double>(ex.nano(b[letter], program::kNano / 1'000)) / 1e9 : 1;
      };
      const double j = share('J'), k = share('K');
      const char written = b.has('J') ? 'J' : 'K';
      if (j <= 0 || k <= 0 || j < kLeastRatio * k || j > kMostRatio * k)
        return fail(ex, rules, Fault::value, written, "J K");
      ex.cycle.retreat_ratio = j / k;
      double& tenths_kept = ex.cycle.runout_tenths;
      if (use == ThreadUse::single && b.has('P')) tenths_kept = b['P'].value();
      const double tenths = tenths_kept >= 0 ? tenths_kept : rules.runout_default;
      const double amount = ex.data.bit(rules.runout_width_parameter) ? tenths * 0.1 * ex.lead_mm : 0;
      job.runout = {amount, amount};
      break;
    }
  }
  (void)axes;
  return true;
}

void remember_thread(Executor& ex, const PlaneAxes& axes, const ThreadPass& job) {
  (void)axes;
  auto& last = ex.cycle.last_thread;
  last = {};
  last.valid = true;
  last.end_first = job.end.u;
  last.end_second = job.end.v;
  last.taper = job.taper;
  last.lead_mm = job.lead_mm;
  last.runout_at = job.runout.length;
  last.runout_short = job.runout.height;
  last.run_in = job.run_in;
  last.starts = job.starts;
}

}  // namespace headstock::cycles
