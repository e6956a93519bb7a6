// `headstock profile P`: prints what a controller's catalogue holds, for people and for scripts.
#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command-line/offline/coverage.hpp"
#include "command-line/offline/offline.hpp"
#include "dialects/catalogue.hpp"
#include "operation/acceleration_modes.hpp"
#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

// A printed table: names of the columns, the rows, and how many columns the short form for people shows.
struct Listing {
  std::string_view name;
  std::vector<std::string_view> columns;
  std::vector<std::vector<std::string_view>> rows;
  std::size_t shown;
};

Listing alarms_of(std::string_view profile) {
  Listing out{"alarms", {"code", "en", "zh", "cause", "cleared_by", "source"}, {}, 3};
  for (const auto& a : dialects::alarms(profile))
    out.rows.push_back({a.code, a.en, a.zh, a.cause, a.cleared_by, a.source});
  return out;
}

Listing parameters_of(std::string_view profile) {
  Listing out{"parameters",
              {"number", "symbol", "meaning", "unit", "default", "range", "name_zh", "effective", "source"},
              {},
              5};
  for (const auto& p : dialects::parameters(profile))
    out.rows.push_back(
        {p.number, p.symbol, p.meaning, p.unit, p.default_value, p.range, p.name_zh, p.effective, p.source});
  return out;
}

Listing mcodes_of(std::string_view profile) {
  Listing out{"mcodes", {"code", "meaning", "source"}, {}, 2};
  for (const auto& m : dialects::mcodes(profile)) out.rows.push_back({m.code, m.meaning, m.source});
  return out;
}

Listing signals_of(std::string_view profile) {
  Listing out{"signals", {"address", "symbol", "direction", "meaning", "source"}, {}, 4};
  for (const auto& s : dialects::signals(profile))
    out.rows.push_back({s.address, s.symbol, s.direction, s.meaning, s.source});
  return out;
}

Listing variables_of(std::string_view profile) {
  Listing out{"variables", {"number", "access", "meaning", "source"}, {}, 3};
  for (const auto& v : dialects::variables(profile))
    out.rows.push_back({v.number, v.access, v.meaning, v.source});
  return out;
}

Listing gcodes_of(std::string_view profile) {
  Listing out{"gcodes", {"code", "B", "C", "group", "handler", "meaning", "state"}, {}, 7};
  for (const auto& g : gcode_states(profile))
    out.rows.push_back({g.a, g.b, g.c, g.group, g.handler, g.meaning, g.done ? "done" : "missing"});
  return out;
}

Listing acceleration_of(std::string_view profile) {
  Listing out{"acceleration", {"motion", "parameter", "curve", "place", "value", "when", "when_2"}, {}, 5};
  for (const operation::AccelerationRow& row : operation::acceleration_rows()) {
    if (!profile.starts_with(row.profile)) continue;
    out.rows.push_back({operation::name_of(row.kind), row.parameter, operation::curve_of(row.unit),
                        operation::place_of(row.unit), operation::value_of(row.unit), row.first.bit,
                        row.second.bit});
  }
  for (const operation::AccelerationGap& gap : operation::acceleration_gaps())
    if (profile.starts_with(gap.profile))
      out.rows.push_back({"not done (HS0031)", gap.parameter, gap.instead, "", "", "", ""});
  return out;
}

struct Choice {
  const char* option;
  const char* help;
  Listing (*list)(std::string_view);
};
constexpr std::array<Choice, 7> kChoices{{
    {"--alarms", "alarms: number, English, Chinese", alarms_of},
    {"--parameters", "parameters: number, symbol, meaning, unit, default", parameters_of},
    {"--gcodes", "G codes with their group in every G-code system", gcodes_of},
    {"--mcodes", "M codes", mcodes_of},
    {"--signals", "PMC / PLC signals", signals_of},
    {"--variables", "macro variables", variables_of},
    {"--acceleration", "acceleration modes: motion, parameter, curve, before or after interpolation, value",
     acceleration_of},
}};

void print(const Listing& listing) {
  for (const auto& row : listing.rows) {
    for (std::size_t i = 0; i < listing.shown; ++i) std::cout << (i == 0 ? "" : "\t") << row[i];
    std::cout << '\n';
  }
}

nlohmann::ordered_json to_json(const Listing& listing) {
  auto out = nlohmann::ordered_json::array();
  for (const auto& row : listing.rows) {
    nlohmann::ordered_json entry;
    for (std::size_t i = 0; i < row.size(); ++i) entry[std::string(listing.columns[i])] = std::string(row[i]);
    out.push_back(std::move(entry));
  }
  return out;
}

// Every code of the catalogue by its state.
nlohmann::ordered_json coverage_of(std::string_view profile) {
  nlohmann::ordered_json out = {{"profile", std::string(profile)}};
  for (const CoverageOf& part : coverage(profile)) {
    auto done = nlohmann::ordered_json::array(), off = done, missing = done;
    for (const Covered& item : part.items) {
      const std::string code(item.code);
      if (item.state == State::off_panel)
        off.push_back({{"code", code}, {"reason", std::string(item.reason)}});
      else
        (item.state == State::done ? done : missing).push_back(code);
    }
    out[std::string(part.kind)] = {{"counts",
                                    {{"total", part.items.size()},
                                     {"done", done.size()},
                                     {"off_panel", off.size()},
                                     {"missing", missing.size()}}},
                                   {"done", done},
                                   {"off_panel", off},
                                   {"missing", missing}};
  }
  return out;
}

void print_coverage(std::string_view profile) {
  for (const CoverageOf& part : coverage(profile)) {
    std::cout << part.kind << ": " << part.items.size() << ", done " << part.count(State::done)
              << ", off the panel " << part.count(State::off_panel) << ", missing "
              << part.count(State::missing) << '\n';
    if (part.count(State::missing) == 0) continue;
    std::cout << "  missing:";
    for (const Covered& item : part.items)
      if (item.state == State::missing) std::cout << ' ' << item.code;
    std::cout << '\n';
  }
}

struct Options {
  std::string profile;
  std::array<bool, kChoices.size()> wanted{};
  bool coverage = false;
  bool page = false;
  bool json = false;
};

int run(const Options& options) {
  const auto known = dialects::profiles();
  if (std::find(known.begin(), known.end(), options.profile) == known.end()) {
    std::cerr << "headstock profile: unknown profile \"" << options.profile << "\"; one of";
    for (const auto profile : known) std::cerr << ' ' << profile;
    std::cerr << '\n';
    return 1;
  }
  nlohmann::ordered_json json = {{"profile", options.profile}};
  bool any = false;
  for (std::size_t i = 0; i < kChoices.size(); ++i) {
    if (!options.wanted[i]) continue;
    any = true;
    const Listing listing = kChoices[i].list(options.profile);
    if (options.json)
      json[std::string(listing.name)] = to_json(listing);
    else
      print(listing);
  }
  if (options.coverage) {
    any = true;
    if (options.json)
      json["coverage"] = coverage_of(options.profile);
    else if (options.page)
      std::cout << coverage_page(options.profile);
    else
      print_coverage(options.profile);
  }
  if (!any) {  // a summary
    for (const auto& choice : kChoices) {
      const Listing listing = choice.list(options.profile);
      if (options.json)
        json[std::string(listing.name)] = listing.rows.size();
      else
        std::cout << listing.name << '\t' << listing.rows.size() << '\n';
    }
  }
  if (options.json) std::cout << json.dump(2) << '\n';
  return std::cout.flush() ? 0 : 1;
}

}  // namespace

void add_profile(options::Command app, int& exit_status) {
  auto options = std::make_shared<Options>();
  auto command =
      app.add_command("profile", "What a controller has: alarms, parameters, codes, and which are done");
  command
      .option("PROFILE", options->profile,
              "fanuc-0i-t, fanuc-0i-m, gsk-2000tc, gsk-218t, k2000tc or lathe-200t")
      .required();
  for (std::size_t i = 0; i < kChoices.size(); ++i)
    command.flag(kChoices[i].option, options->wanted[i], kChoices[i].help);
  command.flag("--coverage", options->coverage,
               "every code, alarm, parameter and variable: done, of the panel only, or missing");
  command.flag("--page", options->page, "with --coverage: the page of the dialect's folder (Markdown)")
      .needs("--coverage");
  command.flag("--json", options->json, "as one JSON object, with every column");
  command.callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace headstock::offline
