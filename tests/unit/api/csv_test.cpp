#include "server/api/http/csv.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace headstock::api {
namespace {

TEST(Csv, ColumnsAreAllNamesInOrder) {
  EXPECT_EQ(csv_of(nlohmann::json::parse(R"([{"a":1,"t":{"en":"x","zh":"甲"}},{"a":null,"b":[1,2]}])")),
            "\xEF\xBB\xBF"
            "a,t.en,t.zh,b\r\n1,x,甲,\r\n,,,1 2\r\n");
}

TEST(Csv, QuotesWhatNeedsIt) {
  EXPECT_EQ(csv_of(nlohmann::json::parse(R"([{"a":"x,\"y\"\nz"}])")), "\xEF\xBB\xBF" "a\r\n\"x,\"\"y\"\"\nz\"\r\n");
}

TEST(Csv, ATextIsNeverAFormula) {
  EXPECT_EQ(csv_of(nlohmann::json::parse(R"([{"a":"=1+1","b":-5.5,"c":"-5"}])")),
            "\xEF\xBB\xBF" "a,b,c\r\n'=1+1,-5.5,'-5\r\n");
}

TEST(Csv, NothingIsAnEmptyTable) { EXPECT_EQ(csv_of(nlohmann::json::array()), "\xEF\xBB\xBF\r\n"); }

}  // namespace
}  // namespace headstock::api
