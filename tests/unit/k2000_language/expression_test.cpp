// The C-like expressions of K2000TC against the manual's chapter 16 and its FAQ.
#include "macro/k2000-language/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace headstock::k2000 {
namespace {

class Store final : public Variables {
 public:
  std::map<std::uint32_t, Value> values;
  Error read(std::uint32_t number, Value& value) override {
    if (number >= 1'000) return Error::no_variable;
    value = values[number];
    return Error::none;
  }
  Error write(std::uint32_t number, const Value& value) override {
    values[number] = value;
    return Error::none;
  }
};

struct Result {
  Value value;
  Error error = Error::none;
};

Result work(std::string_view text, Store& store, const Options& options = {}) {
  Parser parser(text, store, options);
  Result result;
  if (parser.expression(result.value) && !parser.at_end()) parser.fail(Error::syntax);
  result.error = parser.error();
  return result;
}
Result work(std::string_view text, const Options& options = {}) {
  Store store;
  return work(text, store, options);
}

struct Row {
  std::string_view text;
  Type type;
  double value;
};

TEST(K2000Expression, ValuesAndTypes) {
  const Row rows[] = {
      {"5/2", Type::int_, 2},  // L21740: integers divide as integers
      {"5/2.0", Type::double_, 2.5},
      {"[1.0 + 2.0] * 3.0 / 4.0 - [8 >> 2 + 3]", Type::double_, 2.25},  // L19724: + binds tighter than >>
      {"5.5+8", Type::double_, 13.5},
      {"[INT]5.5", Type::int_, 5},
      {"[INT]-5.5", Type::int_, -5},
      {"[FLOAT]1/4", Type::float_, 0.25},
      {"5.1f + 8 - 2.0", Type::double_, 11.10000038146973},  // L21733
      {"0x1F", Type::int_, 31},
      {"5ul", Type::ulong, 5},
      {"5l", Type::long_, 5},
      {"4294967295", Type::uint, 4294967295.0},
      {"4294967296", Type::long_, 4294967296.0},
      {"2147483647+1", Type::int_, -2147483648.0},  // no overflow check
      {"1u-2", Type::uint, 4294967295.0},
      {"-5", Type::int_, -5},
      {"!0", Type::uint, 1},
      {"~0", Type::uint, 4294967295.0},
      {"6 & 3 ^ 1", Type::uint, 3},
      {"6 AND 3", Type::uint, 2},
      {"6 OR 1", Type::uint, 7},
      {"6 XOR 3", Type::uint, 5},
      {"1 && 0 || 1", Type::uint, 1},
      {"2 < 3", Type::uint, 1},
      {"2 GE 3", Type::uint, 0},
      {"2 EQ 2.0", Type::uint, 1},
      {"1 << 33", Type::uint, 0},
      {"1l << 33", Type::ulong, 8589934592.0},
      {"-1 < 1u", Type::uint, 0},  // both become UINT
      {"TRUE", Type::uint, 1},
      {"2.5e3", Type::double_, 2500},
      {"7LE 7", Type::uint, 1},
  };
  for (const Row& row : rows) {
    const Result result = work(row.text);
    ASSERT_EQ(result.error, Error::none) << row.text;
    EXPECT_EQ(result.value.type, row.type) << row.text;
    EXPECT_DOUBLE_EQ(result.value.number(), row.value) << row.text;
  }
}

TEST(K2000Expression, Functions) {
  const Row rows[] = {
      {"FABS[-8.5]", Type::double_, 8.5},
      {"FLOOR[-8.1]", Type::double_, -9},
      {"FLOOR[8.9]", Type::double_, 8},
      {"CEIL[-8.9]", Type::double_, -8},
      {"CEIL[8.1]", Type::double_, 9},
      {"TRUNC[-8.9]", Type::double_, -8},
      {"TRUNC[8.1]", Type::double_, 8},
      {"ROUND[5.1]", Type::double_, 5},
      {"ROUND[5.6]", Type::double_, 6},
      {"fix[2.9]", Type::double_, 2},
      {"FUP[2.1]", Type::double_, 3},
      {"SIN[30]", Type::double_, 0.5},
      {"COS[60]", Type::double_, 0.5},
      {"ATAN[1]", Type::double_, 45},
      {"ATAN[-1]/[-1]", Type::double_, 225},  // 0…360
      {"ATAN[-1/16]", Type::double_, 0},      // the division is whole
      {"ASIN[1]", Type::double_, 90},
      {"SQRT[16]", Type::double_, 4},
      {"POW[2,10]", Type::double_, 1024},
      {"POW[5,0]", Type::double_, 1},
      {"LOG2[8]", Type::double_, 3},
      {"EXP2[3]", Type::double_, 8},
      {"BCD[12]", Type::uint, 0x12},
      {"BIN[18]", Type::uint, 12},
      {"ABS[-5]", Type::uint, 5},
      {"ABS[-5l]", Type::ulong, 5},
      {"FPCLASSIFY[EXP2[-149]]", Type::int_, 4},
      {"FPCLASSIFY[EXP2F[-149]]", Type::int_, 2},  // as the manual prints it
      {"FPCLASSIFY[NAN]", Type::int_, 0},
      {"FPCLASSIFY[INF]", Type::int_, 1},
      {"ISINF[NINF]", Type::int_, -1},
      {"FINITE[1.0]", Type::int_, 1},
      {"ISNAN[SQRT[-1]]", Type::int_, 1},
      {"ISNAN[POW[1,INF]]", Type::int_, 1},
      {"ISNAN[ASIN[2]]", Type::int_, 1},
      {"ISINF[LOG[0]]", Type::int_, -1},
      {"ISNULL[NULL]", Type::int_, 1},
      {"ISNULL[0]", Type::int_, 0},
  };
  for (const Row& row : rows) {
    const Result result = work(row.text);
    ASSERT_EQ(result.error, Error::none) << row.text;
    EXPECT_EQ(result.value.type, row.type) << row.text;
    EXPECT_NEAR(result.value.number(), row.value, 1e-12) << row.text;
  }
}

TEST(K2000Expression, RadiansAndSignedAngles) {
  Options options;
  options.degrees = false;
  const Result tangent = work("TANF[-64*PI]", options);
  EXPECT_EQ(tangent.value.type, Type::float_);
  EXPECT_NEAR(tangent.value.number(), -5.5950577e-6, 1e-12);  // L21692
  options.degrees = true;
  options.signed_atan = true;
  EXPECT_DOUBLE_EQ(work("ATAN[-1]/[-1]", options).value.number(), -135);
}

TEST(K2000Expression, Mistakes) {
  const std::pair<std::string_view, Error> rows[] = {
      {"1+NULL", Error::null_used},
      {"NULL==NULL", Error::null_used},
      {"SIN[NULL]", Error::null_used},
      {"#1+1", Error::undefined},
      {"5.0&1", Error::whole_needed},
      {"~1.5", Error::whole_needed},
      {"ABS[1.5]", Error::whole_needed},
      {"1/0", Error::divide_by_zero},
      {"[1", Error::syntax},
      {"1+", Error::syntax},
      {"FOO[1]", Error::syntax},
      {"POW[1]", Error::syntax},
      {"ATAN[1]/#5", Error::bad_argument},
      {"#2000", Error::no_variable},
      {"r64", Error::no_variable},
      {"#[1.5]", Error::no_variable},
      {"1 2", Error::syntax},
      {"BIN[10]", Error::bad_argument},
  };
  for (const auto& [text, error] : rows) EXPECT_EQ(work(text).error, error) << text;
  EXPECT_EQ(work(std::string(500, '[')).error, Error::syntax);
  EXPECT_EQ(work(std::string(500, '-')).error, Error::syntax);
  EXPECT_EQ(work(std::string(500, '#')).error, Error::syntax);
}

TEST(K2000Expression, IndexAndIndirection) {
  Store store;
  store.values[1] = Value::of_int(5);
  store.values[5] = Value::of_double(7.5);
  store.values[105] = Value::of_int(9);
  EXPECT_DOUBLE_EQ(work("#[#1]", store).value.number(), 7.5);
  EXPECT_DOUBLE_EQ(work("##1", store).value.number(), 7.5);
  EXPECT_DOUBLE_EQ(work("#100[#1]", store).value.number(), 9);
  EXPECT_DOUBLE_EQ(work("r5", store).value.number(), 7.5);
  EXPECT_DOUBLE_EQ(work("r0[#1]", store).value.number(), 7.5);
}

TEST(K2000Expression, RewritesTheOtherBrackets) {
  std::string text = "#100(0)=r5[2] // end (x)";
  rewrite(text);
  EXPECT_EQ(text, "#100[0]=r5{2}           ");
  text = "MSG(\"(a)\", 1) /* (b) */ ";
  rewrite(text);
  EXPECT_EQ(text, "MSG[\"(a)\", 1]           ");
}

TEST(K2000Expression, Texts) {
  EXPECT_EQ(text_of(Value::of_int(7)), "7");
  EXPECT_EQ(text_of(Value::of_double(0.5)), "0.5");
  EXPECT_EQ(text_of({}), "NULL");
}

}  // namespace
}  // namespace headstock::k2000
