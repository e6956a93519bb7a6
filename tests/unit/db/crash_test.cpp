// What happens when the process dies, and when the disk is full.
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "db/blobs.hpp"
#include "db/event_store.hpp"
#include "db/time.hpp"
#include "db/user_store.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::db {
namespace {

using test::TemporaryFolder;

/// Runs `work` in a child process. @return its exit status, or minus the signal that ended it.
int in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    int result = 99;
    try {
      result = work();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "child: %s\n", error.what());
    }
    ::_exit(result);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

void count_one_part(Database& db, std::int64_t sequence) {
  Transaction transaction(db);
  spool_sequence(db, 1, "spool", 1);
  if (insert_event(db, {1, "spool", sequence, 1, 1, "part", "{}"}))
    insert_part(db, {0, 1, "spool", sequence, 1, "O1", "", sequence, sequence, 1.0});
  append_audit(db, {0, now_ms(), "test", "", "part", "1", std::to_string(sequence), "", ""});
  advance_spool(db, 1, "spool");
  transaction.commit();
}

TEST(Crash, KilledWhileWritingLosesNothingThatWasAcknowledged) {
  TemporaryFolder folder;
  std::int64_t acknowledged = 0;
  for (int round = 0; round < 50; ++round) {
    int fds[2];
    ASSERT_EQ(::pipe(fds), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      ::close(fds[0]);
      try {
        const auto db = test::open_shop(folder / "s.db");
        db->execute(
            "INSERT INTO machines (id, name, profile, created_ms) VALUES (1, 'm', 'p', 1) ON CONFLICT DO "
            "NOTHING");
        for (std::int64_t sequence = spool_sequence(*db, 1, "spool", 1) + 1;; ++sequence) {
          count_one_part(*db, sequence);
          if (::write(fds[1], &sequence, sizeof sequence) != static_cast<ssize_t>(sizeof sequence))
            ::_exit(2);
        }
      } catch (const std::exception& error) {
        std::fprintf(stderr, "child: %s\n", error.what());
      }
      ::_exit(3);
    }
    ::close(fds[1]);
    // Killed in the middle of whatever comes after the n-th acknowledgement.
    std::int64_t sequence = 0;
    for (int i = 0; i <= round % 7; ++i)
      ASSERT_EQ(::read(fds[0], &sequence, sizeof sequence), static_cast<ssize_t>(sizeof sequence));
    for (volatile int spin = 0; spin < round * 20'000;) spin = spin + 1;
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    while (::read(fds[0], &sequence, sizeof sequence) == static_cast<ssize_t>(sizeof sequence)) {
    }
    ::close(fds[0]);
    acknowledged = std::max(acknowledged, sequence);
    const auto db = test::open_shop(folder / "s.db");
    EXPECT_EQ(db->text("PRAGMA integrity_check"), "ok");
    const std::int64_t counted = part_total(*db, {});
    EXPECT_GE(counted, acknowledged);
    EXPECT_LE(counted, acknowledged + 1);  // committed, but killed before it could say so
    EXPECT_EQ(db->integer("SELECT COUNT(DISTINCT sequence) FROM parts"), counted);
    EXPECT_EQ(spool_sequence(*db, 1, "spool", 1), counted);
    EXPECT_EQ(first_broken_audit(*db), 0);
    EXPECT_EQ(db->integer("SELECT COUNT(*) FROM audit"), counted);
  }
}

/// A file size limit is what a full disk looks like to the one who writes.
void limit_file_size(rlim_t bytes) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, RLIM_INFINITY};
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

TEST(DiskFull, TheRequestFailsAndTheServerGoesOn) {
  TemporaryFolder folder;
  const int result = in_child([&] {
    const auto db = test::open_shop(folder / "s.db");
    db->execute("INSERT INTO machines (id, name, profile, created_ms) VALUES (1, 'm', 'p', 1)");
    const std::string large(200'000, 'x');
    limit_file_size(std::filesystem::file_size(folder / "s.db-wal") + 20'000);
    bool refused = false;
    try {
      Transaction transaction(*db);
      db->execute("INSERT INTO settings (key, value) VALUES ('first', 'half')");
      db->execute("INSERT INTO settings (key, value) VALUES ('large', ?)", {large});
      transaction.commit();
    } catch (const Error& error) {
      refused = error.problem() == Problem::disk_full;
      if (!refused) std::fprintf(stderr, "%s\n", error.what());
    }
    if (!refused) return 1;
    if (db->integer("SELECT COUNT(*) FROM settings") != 0) return 2;  // nothing half-written
    limit_file_size(RLIM_INFINITY);
    {
      Transaction transaction(*db);
      db->execute("INSERT INTO settings (key, value) VALUES ('large', ?)", {large});
      transaction.commit();
    }
    return db->integer("SELECT COUNT(*) FROM settings") == 1 ? 0 : 3;
  });
  EXPECT_EQ(result, 0);
  const auto db = test::open_shop(folder / "s.db");
  EXPECT_EQ(db->text("PRAGMA integrity_check"), "ok");
  EXPECT_EQ(db->integer("SELECT LENGTH(value) FROM settings WHERE key = 'large'"), 200'000);
}

TEST(DiskFull, ARealOneToo) {
  TemporaryFolder folder;
  if (::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=1m") != 0)
    GTEST_SKIP() << "may not mount a small disk here";
  struct Unmount {
    std::filesystem::path path;
    ~Unmount() { ::umount(path.c_str()); }
  } unmount{folder.path()};
  {
    const auto db = test::open_shop(folder / "s.db");
    bool refused = false;
    std::int64_t written = 0;
    try {
      for (; written < 100; ++written)
        db->execute("INSERT INTO settings (key, value) VALUES (?, ?)", {written, std::string(50'000, 'x')});
    } catch (const Error& error) {
      refused = error.problem() == Problem::disk_full;
    }
    EXPECT_TRUE(refused);
    EXPECT_EQ(db->integer("SELECT COUNT(*) FROM settings"), written);
    db->integer("SELECT COUNT(*) FROM users");
  }
  EXPECT_EQ(test::open_shop(folder / "s.db")->text("PRAGMA integrity_check"), "ok");
}

TEST(DiskFull, AnUploadLeavesNothing) {
  TemporaryFolder folder;
  const int result = in_child([&] {
    const Blobs blobs(folder.path());
    limit_file_size(100'000);
    try {
      auto writer = blobs.begin();
      for (int i = 0; i < 4; ++i) writer.append(std::string(50'000, 'x'));
      return 1;
    } catch (const Error& error) {
      if (error.problem() != Problem::disk_full) return 2;
    }
    limit_file_size(RLIM_INFINITY);
    auto writer = blobs.begin();
    writer.append(std::string(200'000, 'x'));
    return blobs.verify(writer.finish()) ? 0 : 3;
  });
  EXPECT_EQ(result, 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "blobs/incoming"));
}

TEST(Upload, OfHundredMegabytesStaysSmallInMemory) {
  TemporaryFolder folder;
  const int result = in_child([&] {
    const Blobs blobs(folder.path());
    rusage before{}, after{};
    ::getrusage(RUSAGE_SELF, &before);
    auto writer = blobs.begin();
    const std::string piece(65'536, 'G');
    for (int i = 0; i < 1'600; ++i) writer.append(piece);
    const std::string sha256 = writer.finish();
    if (!blobs.verify(sha256)) return 1;
    ::getrusage(RUSAGE_SELF, &after);
    return after.ru_maxrss - before.ru_maxrss < 8 * 1024 ? 0 : 2;  // KiB
  });
  EXPECT_EQ(result, 0);
}

}  // namespace
}  // namespace headstock::db
