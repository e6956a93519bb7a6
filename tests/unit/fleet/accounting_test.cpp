// Shifts over changes of the clocks, why machines stood, and the figures made of it.
#include <gtest/gtest.h>

#include "db/event_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/oee.hpp"
#include "server/fleet/states.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::fleet {
namespace {

constexpr std::int64_t kHour = 3'600'000, kMinute = 60'000, kDay = 24 * kHour;
// 2026-03-29 and 2026-10-25, midnight UTC: Berlin's clocks change at 01:00 UTC.
constexpr std::int64_t kSpring = 1'774'742'400'000, kAutumn = 1'792'886'400'000;
constexpr std::uint8_t kEveryDay = 127;

Calendar berlin(std::vector<Shift> shifts) {
  return {"Europe/Berlin", std::move(shifts)};
}

TEST(Shifts, ANightShiftIsAsLongAsTheNightReallyIs) {
  const Calendar calendar = berlin({{"Night", kEveryDay, 22 * 60, 6 * 60}});
  const auto over = [&](std::int64_t midnight) {
    return shift_spans(calendar, {midnight, midnight + kHour}).at(0);
  };
  EXPECT_EQ(over(kSpring).length_ms(), 7 * kHour);
  EXPECT_EQ(over(kSpring).day, "2026-03-28");
  EXPECT_EQ(over(kAutumn).length_ms(), 9 * kHour);
  EXPECT_EQ(over(kSpring + 7 * kDay).length_ms(), 8 * kHour);
}

TEST(Shifts, AClockTimeThatDoesNotExistIsWhereTheClockJumps) {
  const auto spans =
      shift_spans(berlin({{"Odd", kEveryDay, 2 * 60 + 30, 4 * 60}}), {kSpring, kSpring + 2 * kHour});
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0].from_ms, kSpring + kHour);
  EXPECT_EQ(spans[0].to_ms, kSpring + 2 * kHour);
}

TEST(Shifts, DaysHave23And25Hours) {
  EXPECT_EQ(local_days("Europe/Berlin", {kSpring, kSpring + kHour}).at(0).length_ms(), 23 * kHour);
  EXPECT_EQ(local_days("Europe/Berlin", {kAutumn, kAutumn + kHour}).at(0).length_ms(), 25 * kHour);
  const auto weeks = local_weeks("Asia/Shanghai", {kSpring, kSpring + 8 * kDay});
  ASSERT_EQ(weeks.size(), 3u);
  EXPECT_EQ(weeks[0].day, "2026-03-23");
  EXPECT_EQ(weeks[1].day, "2026-03-30");
}

TEST(Shifts, OnlyOnTheirDays) {
  // 2026-03-30 is a Monday.
  const auto spans =
      shift_spans({"Etc/UTC", {{"Mondays", 1, 8 * 60, 16 * 60}}}, {kSpring - kDay, kSpring + 7 * kDay});
  ASSERT_EQ(spans.size(), 1u);
  EXPECT_EQ(spans[0].day, "2026-03-30");
}

struct Accounting : testing::Test {
  test::TemporaryFolder folder;
  db::Store store{folder.path(), test::test_database()};
  std::int64_t machine = 0;
  access::Actor operator_{7, "li", access::Role::operator_, ""}, setter{8, "wang", access::Role::setter, ""};
  // A Monday, 06:00 UTC.
  const std::int64_t start = kSpring + kDay + 6 * kHour;
  std::int64_t sequence = 0;

  Accounting() {
    in([&](db::Database& db) {
      machine = create_machine(db, {}, "Lathe", "fanuc-0i-t", "", 1).id;
      write_calendar(db, setter,
                     {"Etc/UTC", {{"Early", 31, 6 * 60, 14 * 60}, {"Late", 31, 14 * 60, 22 * 60}}});
    });
  }
  void in(const std::function<void(db::Database&)>& work) { store.now(work); }
  void state(const std::string& state, std::int64_t minutes) {
    in([&](db::Database& db) {
      record_state(db, machine, state, "memory", start + minutes * kMinute, Witness::machine);
    });
  }
  void part(std::int64_t minutes, const std::string& sha256) {
    in([&](db::Database& db) {
      ++sequence;
      db::spool_sequence(db, machine, "s", start);
      db::insert_event(db, {machine, "s", sequence, start + minutes * kMinute, start, "part", "{}"});
      db::insert_part(
          db, {0, machine, "s", sequence, start + minutes * kMinute, "O1", sha256, sequence, sequence, 60});
    });
  }
  void check(const std::string& sha256, double time_s) {
    in([&](db::Database& db) {
      db.execute("INSERT INTO blobs VALUES (?, 1, 1, 1, 'ascii', 'lf', 0, 1, 1)", {sha256});
      db.execute(
          "INSERT INTO checks (sha256, machine_id, config_hash, offsets_version, checker, ok, result_json, "
          "at_ms) "
          "VALUES (?, ?, '', 0, '', 1, ?, 1)",
          {sha256, machine, "{\"time_s\":" + std::to_string(time_s) + "}"});
    });
  }
  void note(std::int64_t from_minutes, std::int64_t to_minutes, std::optional<std::int64_t> reason) {
    in([&](db::Database& db) {
      DowntimeNote entry;
      entry.machine = machine;
      entry.from_ms = start + from_minutes * kMinute;
      entry.to_ms = start + to_minutes * kMinute;
      entry.reason = reason;
      note_downtime(db, operator_, entry, start + kDay);
    });
  }
  std::int64_t reason(bool planned) {
    std::int64_t id = 0;
    in([&](db::Database& db) {
      for (const auto& one : downtime_reasons(db))
        if (one.planned == planned) id = one.id;
    });
    return id;
  }
  std::vector<OeeRow> report(OeeBy by, std::int64_t now_minutes) {
    std::vector<OeeRow> rows;
    in([&](db::Database& db) {
      rows = oee(db, machine, {start, start + kDay}, by, start + now_minutes * kMinute);
    });
    return rows;
  }
  std::string refused(const std::function<void(db::Database&)>& work) {
    try {
      in(work);
    } catch (const db::Refusal& refusal) {
      return refusal.code();
    }
    return "";
  }
};

TEST_F(Accounting, EveryMinuteOfAShiftIsSomewhere) {
  state("running", 0);
  state("alarm", 60);
  state("idle", 90);
  state("running", 120);
  in([&](db::Database& db) { record_silence(db, machine, "unknown", start + 180 * kMinute); });
  const auto rows = report(OeeBy::shift, 240);
  ASSERT_EQ(rows.size(), 1u);
  const Figures& got = rows[0].figures;
  EXPECT_EQ(rows[0].shift, "Early");
  EXPECT_EQ(got.scheduled_ms, 240 * kMinute);
  EXPECT_EQ(got.running_ms(), 120 * kMinute);
  EXPECT_EQ(got.in_state_ms[4], 30 * kMinute) << "alarm";
  EXPECT_EQ(got.in_state_ms[3], 30 * kMinute) << "idle";
  EXPECT_EQ(got.unknown_ms(), 60 * kMinute);
  EXPECT_EQ(got.unexplained_ms, 60 * kMinute);
  EXPECT_DOUBLE_EQ(got.availability().value(), 120.0 / 180)
      << "what nobody knows is neither standing nor running";
}

TEST_F(Accounting, APlannedStopIsNotTheMachinesLoss) {
  state("running", 0);
  state("idle", 60);
  state("running", 120);
  note(60, 90, reason(true));
  note(90, 120, reason(false));
  const Figures got = report(OeeBy::machine, 180).at(0).figures;
  EXPECT_EQ(got.planned_stop_ms, 30 * kMinute);
  EXPECT_EQ(got.unexplained_ms, 0);
  EXPECT_EQ(got.by_reason_ms.at(reason(false)), 30 * kMinute);
  EXPECT_DOUBLE_EQ(got.availability().value(), 120.0 / 150);
}

TEST_F(Accounting, ANoteOverRunningTimeExplainsOnlyTheStop) {
  state("running", 0);
  state("idle", 60);
  state("running", 70);
  note(0, 120, reason(true));
  const Figures got = report(OeeBy::machine, 120).at(0).figures;
  EXPECT_EQ(got.planned_stop_ms, 10 * kMinute);
}

TEST_F(Accounting, TheFiguresAreTheirDefinitions) {
  state("running", 0);
  state("idle", 60);
  check("aa", 300);
  for (int i = 0; i < 10; ++i) part(6 * (i + 1) - 1, "aa");
  in([&](db::Database& db) {
    note_reject(db, operator_, {0, machine, start + 30 * kMinute, "O1", 1, "chatter", "", 0}, start + kDay);
  });
  const Figures got = report(OeeBy::machine, 120).at(0).figures;
  EXPECT_EQ(got.parts, 10);
  EXPECT_EQ(got.rejects, 1);
  EXPECT_DOUBLE_EQ(got.availability().value(), 0.5);
  EXPECT_DOUBLE_EQ(got.performance().value(), 10 * 300.0 / 3600);
  EXPECT_DOUBLE_EQ(got.quality().value(), 0.9);
  EXPECT_DOUBLE_EQ(got.oee().value(), 0.5 * (3000.0 / 3600) * 0.9);
}

TEST_F(Accounting, WhatNobodyPredictedMakesThePerformanceUnknown) {
  state("running", 0);
  part(5, "bb");
  const Figures got = report(OeeBy::machine, 60).at(0).figures;
  EXPECT_EQ(got.parts_without_ideal, 1);
  EXPECT_FALSE(got.performance());
  EXPECT_FALSE(got.oee());
  EXPECT_DOUBLE_EQ(got.availability().value(), 1);
}

TEST_F(Accounting, NothingIsScheduledOnASunday) {
  std::vector<OeeRow> rows;
  in([&](db::Database& db) {
    rows = oee(db, machine, {kSpring, kSpring + kDay}, OeeBy::day, kSpring + 2 * kDay);
  });
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].figures.scheduled_ms, 0);
  EXPECT_FALSE(rows[0].figures.availability());
}

TEST_F(Accounting, ShiftsAndDaysAddUp) {
  state("running", 0);
  state("idle", 500);
  state("running", 700);
  std::int64_t running = 0;
  for (const OeeRow& row : report(OeeBy::shift, 960)) running += row.figures.running_ms();
  EXPECT_EQ(running, report(OeeBy::day, 960).at(0).figures.running_ms());
  EXPECT_EQ(running, report(OeeBy::week, 960).at(0).figures.running_ms());
  EXPECT_EQ(running, (500 + 260) * kMinute);
}

TEST_F(Accounting, StopsAreWhatLiesBetweenRunning) {
  state("running", 0);
  state("hold", 10);
  state("alarm", 12);
  state("idle", 30);
  state("running", 31);
  state("hold", 40);
  state("running", 41);
  in([&](db::Database& db) { record_silence(db, machine, "unknown", start + 50 * kMinute); });
  note(5, 20, reason(false));
  std::vector<Stop> found;
  in([&](db::Database& db) {
    found = stops(db, machine, {start, start + kDay}, 2 * kMinute, start + 60 * kMinute);
  });
  ASSERT_EQ(found.size(), 2u) << "the minute of hold is too short to ask for";
  EXPECT_EQ(found[0].from_ms, start + 10 * kMinute);
  EXPECT_EQ(found[0].to_ms, start + 31 * kMinute);
  EXPECT_EQ(found[0].state, "alarm") << "most of it";
  ASSERT_TRUE(found[0].note);
  EXPECT_EQ(found[0].note->by_user, "li");
  EXPECT_EQ(found[1].state, "unknown");
  EXPECT_TRUE(found[1].open);
}

TEST_F(Accounting, TheNewerNoteCountsAndTheRestOfTheOlderStays) {
  note(0, 100, reason(true));
  note(40, 60, reason(false));
  note(50, 55, std::nullopt);
  std::vector<DowntimeNote> got;
  in([&](db::Database& db) { got = settled(downtime_notes(db, machine, {start, start + kDay})); });
  ASSERT_EQ(got.size(), 4u);
  const std::int64_t ends[] = {0, 40, 40, 50, 55, 60, 60, 100};
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].from_ms, start + ends[2 * i] * kMinute) << i;
    EXPECT_EQ(got[i].to_ms, start + ends[2 * i + 1] * kMinute) << i;
  }
  EXPECT_TRUE(got[0].planned);
  EXPECT_FALSE(got[1].planned);
}

TEST_F(Accounting, BadInputIsRefusedInWords) {
  const auto calendar = [&](Calendar wanted) {
    return refused([&, wanted](db::Database& db) { write_calendar(db, setter, wanted); });
  };
  EXPECT_EQ(calendar({"Mars/Olympus", {}}), "bad_value");
  EXPECT_EQ(calendar({"Etc/UTC", {{"A", kEveryDay, 0, 600}, {"B", kEveryDay, 500, 700}}}), "shifts_overlap");
  EXPECT_EQ(calendar({"Etc/UTC", {{"A", 64, 20 * 60, 8 * 60}, {"B", 1, 7 * 60, 9 * 60}}}), "shifts_overlap")
      << "Sunday's night shift meets Monday";
  EXPECT_EQ(calendar({"Etc/UTC", {{"", 1, 0, 600}}}), "bad_value");
  EXPECT_EQ(refused([&](db::Database& db) { write_calendar(db, operator_, {"Etc/UTC", {}}); }), "forbidden");
  const auto entry = [&](std::int64_t from, std::int64_t to, std::optional<std::int64_t> why) {
    return refused([&](db::Database& db) {
      DowntimeNote wanted;
      wanted.machine = machine;
      wanted.from_ms = from;
      wanted.to_ms = to;
      wanted.reason = why;
      note_downtime(db, operator_, wanted, start);
    });
  };
  EXPECT_EQ(entry(start - kHour, start - kHour, reason(true)), "bad_value");
  EXPECT_EQ(entry(start - kHour, start + kHour, reason(true)), "in_the_future");
  EXPECT_EQ(entry(start - kHour, start, 12345), "not_found");
  EXPECT_EQ(refused([&](db::Database& db) {
              note_reject(db, operator_, {0, machine, start, "O1", 1, "", "", 0}, start);
            }),
            "reason_missing");
  EXPECT_EQ(refused([&](db::Database& db) {
              oee(db, machine, {start, start}, OeeBy::day, start);
            }),
            "bad_value");
}

}  // namespace
}  // namespace headstock::fleet
