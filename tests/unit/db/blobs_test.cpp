#include "db/blobs.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>

#include "db/database.hpp"
#include "tests/unit/db/shop_database.hpp"

namespace headstock::db {
namespace {

using test::TemporaryFolder;

std::size_t files_in(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    count += entry.is_regular_file();
  return count;
}

TEST(Blobs, AreNamedByTheirContentAndReadAtAnyPlace) {
  TemporaryFolder folder;
  const Blobs blobs(folder.path());
  auto writer = blobs.begin();
  writer.append("abc");
  writer.append("def");
  const std::string sha256 = writer.finish();
  EXPECT_EQ(sha256, "bef57ec7f53a6d40beb640a780a639c83bc29ac8a9816f1fc6c5c6dcd93c4721");
  const auto reader = blobs.open(sha256);
  EXPECT_EQ(reader->size(), 6u);
  std::array<char, 10> bytes{};
  EXPECT_EQ(reader->read(4, bytes.data(), bytes.size()), 2u);
  EXPECT_EQ(bytes[0], 'e');
  EXPECT_EQ(reader->read(6, bytes.data(), bytes.size()), 0u);
  EXPECT_EQ(blobs.map(sha256)->view(), "abcdef");
  EXPECT_TRUE(blobs.verify(sha256));
}

TEST(Blobs, TheSameContentIsKeptOnce) {
  TemporaryFolder folder;
  const Blobs blobs(folder.path());
  for (int i = 0; i < 3; ++i) {
    auto writer = blobs.begin();
    writer.append("G01");
    writer.finish();
  }
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(Blobs, HalfAnUploadVanishes) {
  TemporaryFolder folder;
  {
    const Blobs blobs(folder.path());
    {
      auto writer = blobs.begin();
      writer.append("half");
      EXPECT_EQ(files_in(folder.path()), 1u);
    }
    EXPECT_EQ(files_in(folder.path()), 0u);
  }
  std::ofstream(folder.path() / "blobs/incoming/left-by-a-crash") << "half";
  const Blobs blobs(folder.path());
  EXPECT_EQ(files_in(folder.path()), 0u);
}

TEST(Blobs, DamageIsFoundAndHealedByANewUpload) {
  TemporaryFolder folder;
  const Blobs blobs(folder.path());
  const auto put = [&] {
    auto writer = blobs.begin();
    writer.append("G01 X10.");
    return writer.finish();
  };
  const std::string sha256 = put();
  std::filesystem::permissions(blobs.path(sha256), std::filesystem::perms::owner_all);
  std::filesystem::resize_file(blobs.path(sha256), 3);
  EXPECT_FALSE(blobs.verify(sha256));
  put();
  EXPECT_TRUE(blobs.verify(sha256));
  EXPECT_FALSE(blobs.verify(std::string(64, '0')));
  EXPECT_THROW(blobs.open(std::string(64, '0')), Error);
  EXPECT_THROW(blobs.path("../../etc/passwd"), Error);
}

}  // namespace
}  // namespace headstock::db
