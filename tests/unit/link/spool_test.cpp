// The spool promises: committed is on disk, in order, once; a process may die at any instant.
#include "link/spool.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/unit/temporary_folder.hpp"

namespace headstock::link {
namespace {

using testing_support::TemporaryFolder;
namespace fs = std::filesystem;

NewEvent part(int n) {
  return {1000 + n, "part", "{\"count\":" + std::to_string(n) + "}"};
}

TEST(Spool, KeepsEventsInOrderAndItsIdOverRestart) {
  const TemporaryFolder folder;
  std::string id;
  {
    Spool spool(folder.path() / "spool.sqlite");
    id = spool.id();
    ASSERT_EQ(id.size(), 36u);
    const NewEvent events[] = {part(1), part(2), part(3)};
    EXPECT_EQ(spool.commit(events), 3u);
  }
  Spool spool(folder.path() / "spool.sqlite");
  EXPECT_EQ(spool.id(), id);
  EXPECT_EQ(spool.pending(), 3u);
  const auto events = spool.read_after(1);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].sequence, 2u);
  EXPECT_EQ(events[0].body, "{\"count\":2}");
  EXPECT_EQ(events[1].at_ms, 1003);
}

TEST(Spool, AcknowledgedEventsGoAndTheirSequenceIsNeverUsedAgain) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "spool.sqlite";
  {
    Spool spool(file);
    const NewEvent events[] = {part(1), part(2)};
    spool.commit(events);
    spool.acknowledge(2);
    EXPECT_EQ(spool.pending(), 0u);
    EXPECT_TRUE(spool.read_after(0).empty());
  }
  Spool spool(file);
  EXPECT_EQ(spool.pending(), 0u);
  const NewEvent next[] = {part(3)};
  EXPECT_EQ(spool.commit(next), 3u);
  spool.acknowledge(99);  // a server that acknowledges more than it was sent changes nothing beyond the last
  EXPECT_EQ(spool.acknowledged(), 3u);
}

TEST(Spool, RetainedValuesAreWrittenAndErased) {
  const TemporaryFolder folder;
  Spool spool(folder.path() / "spool.sqlite");
  const RetainedValue values[] = {{"parts", "12"}, {"program", "O1001"}};
  spool.commit({}, values);
  EXPECT_EQ(spool.retained("parts"), "12");
  const RetainedValue erase[] = {{"parts", std::nullopt}};
  spool.commit({}, erase);
  EXPECT_EQ(spool.retained("parts"), std::nullopt);
  EXPECT_EQ(spool.all_retained().size(), 1u);
  EXPECT_EQ(spool.last_sequence(), 0u) << "retained values are no events";
}

TEST(Spool, ReadsBoundedBatches) {
  const TemporaryFolder folder;
  Spool spool(folder.path() / "spool.sqlite");
  std::vector<NewEvent> events;
  for (int n = 0; n < 300; ++n) events.push_back(part(n));
  spool.commit(events);
  EXPECT_EQ(spool.read_after(0).size(), 256u);
  EXPECT_EQ(spool.read_after(0, 10).size(), 10u);
  EXPECT_EQ(spool.read_after(0, 10, 1).size(), 1u) << "at least one, however big";
  EXPECT_THROW(spool.commit(std::vector{NewEvent{0, "x", std::string(65 << 10, ' ')}}), SpoolError);
  EXPECT_EQ(spool.last_sequence(), 300u);
}

TEST(Spool, TellsOfEachCommitWithEvents) {
  const TemporaryFolder folder;
  Spool spool(folder.path() / "spool.sqlite");
  int told = 0;
  spool.on_commit([&] { ++told; });
  spool.commit(std::vector{part(1)});
  spool.commit({}, std::vector<RetainedValue>{{"a", "b"}});
  EXPECT_EQ(told, 1);
}

TEST(Spool, DamagedFileIsRefusedSetAsideAndKept) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "spool.sqlite";
  std::string first_id;
  {
    Spool spool(file);
    first_id = spool.id();
    for (int n = 0; n < 200; ++n) spool.commit(std::vector{part(n)});
  }
  {
    std::fstream damage(file, std::ios::in | std::ios::out | std::ios::binary);
    damage.seekp(4096);
    const std::string garbage(8192, '\x5a');
    damage.write(garbage.data(), static_cast<std::streamsize>(garbage.size()));
  }
  const auto damaged_size = fs::file_size(file);
  EXPECT_THROW({ Spool spool(file); }, SpoolDamaged);
  EXPECT_EQ(fs::file_size(file), damaged_size) << "refusing changes nothing";
  const fs::path aside = Spool::set_aside(file);
  EXPECT_EQ(fs::file_size(aside), damaged_size);
  Spool fresh(file);
  EXPECT_NE(fresh.id(), first_id) << "a new spool starts at 1 again, so it must not look like the old one";
}

TEST(Spool, NotADatabaseIsDamaged) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "spool.sqlite";
  std::ofstream(file) << std::string(5000, 'x');
  EXPECT_THROW({ Spool spool(file); }, SpoolDamaged);
}

TEST(Spool, SecondProcessIsRefused) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "spool.sqlite";
  Spool spool(file);
  try {
    Spool second(file);
    FAIL() << "two agents on one spool";
  } catch (const SpoolDamaged&) {
    FAIL() << "in use is not damaged";
  } catch (const SpoolError& error) {
    EXPECT_NE(std::string(error.what()).find("second agent"), std::string::npos) << error.what();
  }
}

TEST(Spool, UnwritableFolderIsAClearError) {
  EXPECT_THROW({ Spool spool("/nonexistent-folder/spool.sqlite"); }, SpoolError);
}

/// A child counts parts until it is killed; each part is an event and a retained total in one commit.
[[noreturn]] void count_until_killed(const fs::path& file, int told) {
  Spool spool(file);
  for (;;) {
    const long total = std::stol(spool.retained("total").value_or("0")) + 1;
    const RetainedValue values[] = {{"total", std::to_string(total)}};
    spool.commit(std::vector{part(static_cast<int>(total))}, values);
    if (::write(told, &total, sizeof total) != sizeof total) std::_Exit(1);
  }
}

TEST(Spool, KilledAtAnyInstantCountsEachPartOnce) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "spool.sqlite";
  std::mt19937 random(1);
  long reported = 0;
  for (int round = 0; round < 30; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(pipe_ends[0]);
      count_until_killed(file, pipe_ends[1]);
    }
    ::close(pipe_ends[1]);
    const auto parts = 1 + random() % 20;
    for (auto n = parts; n > 0; --n)
      ASSERT_EQ(::read(pipe_ends[0], &reported, sizeof reported), static_cast<ssize_t>(sizeof reported));
    ::usleep(static_cast<useconds_t>(random() % 500));  // anywhere in the next commit
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    for (long more = 0; ::read(pipe_ends[0], &more, sizeof more) == static_cast<ssize_t>(sizeof more);)
      reported = more;
    ::close(pipe_ends[0]);

    const Spool spool(file);
    const long total = std::stol(spool.retained("total").value_or("0"));
    EXPECT_GE(total, reported) << "a part that was reported as counted is gone";
    EXPECT_LE(total, reported + 1);
    EXPECT_EQ(spool.last_sequence(), static_cast<std::uint64_t>(total)) << "events and total disagree";
  }
}

}  // namespace
}  // namespace headstock::link
