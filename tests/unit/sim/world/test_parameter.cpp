#include "sim/world/parameter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <stdexcept>

#include "tests/support/said.hpp"

namespace ilp::world {
namespace {

struct Fields {
  double length = 2;
  int count = 3;
  std::uint64_t seed = 1;
  bool on = false;
  std::string word = "hill";

  std::vector<Parameter> parameters() {
    return {{"length", &length, "m", "how long", 0.5, 100},
            {"count", &count, "", "how many", 1, 9},
            {"seed", &seed, "", ""},
            {"on", &on, "", ""},
            {"word", &word, "", ""}};
  }
};

constexpr auto complaint = test::error_of<std::invalid_argument>;

TEST(Parameter, AnglesAreRadiansOrDegreesThatSaySo) {
  double azimuth = 0;
  const std::vector<Parameter> parameters = {{"azimuth", &azimuth, "rad", "towards where", -6.3, 6.3}};
  set_parameter(parameters, "s", "azimuth", "90deg");
  EXPECT_NEAR(azimuth, std::acos(0), 1e-15);
  set_parameter(parameters, "s", "azimuth", "1.5");
  EXPECT_EQ(azimuth, 1.5);
  const std::string refused = complaint([&] { set_parameter(parameters, "s", "azimuth", "90"); });
  EXPECT_NE(refused.find("rad, or degrees, written 90deg"), std::string::npos) << refused;
  EXPECT_NE(complaint([&] { set_parameter(parameters, "s", "azimuth", "900deg"); }), "");
  Fields fields;
  EXPECT_NE(complaint([&] { set_parameter(fields.parameters(), "s", "length", "2deg"); }), "");
}

TEST(Parameter, TextSetsEveryKindOfField) {
  Fields fields;
  const auto set = [&](const char* name, const char* text) { set_parameter(fields.parameters(), "s", name, text); };
  set("length", "1.25e1");
  set("count", "9");
  set("seed", "18446744073709551615");
  set("on", "true");
  set("word", "a b = c");
  EXPECT_EQ(fields.length, 12.5);
  EXPECT_EQ(fields.count, 9);
  EXPECT_EQ(fields.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(fields.on);
  EXPECT_EQ(fields.word, "a b = c");
}

TEST(Parameter, TextOfAFieldSetsTheSameValue) {
  Fields fields, other;
  fields.length = 100.0 / 3;
  fields.seed = 1ULL << 63U;
  fields.on = true;
  fields.word = "dale";
  for (const Parameter& parameter : fields.parameters()) {
    set_parameter(other.parameters(), "s", parameter.name, parameter_text(parameter));
  }
  EXPECT_EQ(other.length, fields.length);
  EXPECT_EQ(other.seed, fields.seed);
  EXPECT_EQ(other.on, fields.on);
  EXPECT_EQ(other.word, fields.word);
}

TEST(Parameter, NumberTextIsTheShortestThatReadsBack) {
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(1e-7), "1e-07");
  for (const double value : {1.0 / 3, 2.0 / 3e10, -123456.789, 0.1 + 0.2}) {
    EXPECT_EQ(std::strtod(number_text(value).c_str(), nullptr), value);
  }
}

TEST(Parameter, WhatIsWrongAndWhatWasExpectedAreNamed) {
  Fields fields;
  const auto set = [&](const char* name, const char* text) {
    return complaint([&] { set_parameter(fields.parameters(), "box", name, text); });
  };
  EXPECT_EQ(set("length", "0.4"), "[box] length = 0.4: expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("length", "100.1"), "[box] length = 100.1: expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("length", "nan"), "[box] length = nan: expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("length", "inf"), "[box] length = inf: expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("length", "3m"), "[box] length = 3m: expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("length", ""), "[box] length = : expected a number from 0.5 to 100 m");
  EXPECT_EQ(set("count", "2.5"), "[box] count = 2.5: expected a whole number from 1 to 9");
  EXPECT_EQ(set("count", "99999999999"), "[box] count = 99999999999: expected a whole number from 1 to 9");
  EXPECT_EQ(set("seed", "-1"), "[box] seed = -1: expected a whole number");
  EXPECT_EQ(set("on", "1"), "[box] on = 1: expected true or false");
  EXPECT_EQ(set("lenght", "1"),
            "[box] lenght: no such parameter; there are length, count, seed, on, word; did you mean length?");
  EXPECT_EQ(fields.length, 2);
}

TEST(Parameter, NumbersSetInCodeAreChecked) {
  Fields fields;
  EXPECT_NO_THROW(check_parameters(fields.parameters(), "box"));
  fields.length = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint([&] { check_parameters(fields.parameters(), "box"); }),
            "[box] length = nan: expected a number from 0.5 to 100 m");
  fields.length = 2;
  fields.count = 10;
  EXPECT_EQ(complaint([&] { check_parameters(fields.parameters(), "box"); }),
            "[box] count = 10: expected a number from 1 to 9");
}

}  // namespace
}  // namespace ilp::world
