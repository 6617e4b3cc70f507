// The list of status codes is complete and usable, and a Status says what it was made with.
#include "fsw/base/status.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <regex>
#include <set>
#include <string>

#include "fsw/base/status_values.hpp"

namespace ilp {
namespace {

TEST(StatusList, EveryCodeHasItsOwnNameTextAndAdvice) {
  std::set<std::string> names;
  for (int i = 0; i < status_code_limit; ++i) {
    if (!is_status_code(static_cast<std::uint64_t>(i))) continue;
    const auto code = static_cast<StatusCode>(i);
    const std::string name = status_name(code);
    EXPECT_TRUE(names.insert(name).second) << name << " twice";
    for (const char c : name) EXPECT_TRUE(std::islower(c) || std::isdigit(c) || c == '_') << name;
    EXPECT_FALSE(std::string(status_text(code)).empty()) << name;
    EXPECT_FALSE(std::string(status_advice(code)).empty()) << name;
  }
}

TEST(StatusList, PlaceHoldersAreOnlyTheTwoValues) {
  for (int i = 0; i < status_code_limit; ++i) {
    const std::string text = status_text(static_cast<StatusCode>(i));
    for (std::size_t at = text.find('%'); at != std::string::npos; at = text.find('%', at + 1)) {
      ASSERT_LT(at + 1, text.size()) << text;
      EXPECT_TRUE(text[at + 1] == 'a' || text[at + 1] == 'b') << text;
    }
  }
}

TEST(StatusList, EveryValueInATextHasANameAndATypeAndEachTypeIsUsed) {
  std::set<ValueType> used = {ValueType::none};
  for (int i = 0; i < status_code_limit; ++i) {
    if (!is_status_code(static_cast<std::uint64_t>(i))) continue;
    const auto code = static_cast<StatusCode>(i);
    const StatusValues values = status_values(code);
    for (const auto& [mark, value] : {std::pair("%a", values.a), std::pair("%b", values.b)}) {
      const bool shown = std::string(status_text(code)).find(mark) != std::string::npos;
      EXPECT_TRUE(!shown || value.type != ValueType::none) << status_name(code) << " " << mark;
      EXPECT_EQ(value.name[0] == 0, value.type == ValueType::none) << status_name(code) << " " << mark;
      used.insert(value.type);
    }
  }
  EXPECT_EQ(used.size(), static_cast<std::size_t>(ValueType::count));
}

TEST(StatusList, TextsLeaveNamesAndUnitsToTheTypes) {
  const std::regex number_of_a_name("(reason|fault|condition|verdict|component number|because of code) %[ab]");
  const std::regex unit("%[ab](/1000)? (px|pixels?|ms|us|ns|s|milliseconds|microseconds|bytes|octets|bits)\\b");
  for (int i = 0; i < status_code_limit; ++i) {
    const std::string text = status_text(static_cast<StatusCode>(i));
    EXPECT_FALSE(std::regex_search(text, number_of_a_name)) << text;
    EXPECT_FALSE(std::regex_search(text, unit)) << text;
    EXPECT_EQ(text.find("100000"), std::string::npos) << text;
  }
}

TEST(StatusList, SeveritiesOfTheUsualSuspects) {
  EXPECT_EQ(status_severity(StatusCode::ok), Severity::info);
  EXPECT_EQ(status_severity(StatusCode::assertion_failed), Severity::high);
  EXPECT_STREQ(status_name(StatusCode::ok), "ok");
}

TEST(StatusList, ACodeFromOutsideReadsAsTheFirstFault) {
  const auto unknown = static_cast<StatusCode>(0xFFFF);
  EXPECT_STREQ(status_name(unknown), "assertion_failed");
  EXPECT_STREQ(status_name(static_cast<StatusCode>(status_code_limit)), "assertion_failed");
}

TEST(Status, CarriesCodeAndValues) {
  const Status fine;
  EXPECT_TRUE(fine.ok());
  const Status status(StatusCode::capacity_exceeded, 7, 5);
  EXPECT_FALSE(status.ok());
  EXPECT_TRUE(status.is(StatusCode::capacity_exceeded));
  EXPECT_FALSE(status.is(StatusCode::ok));
  EXPECT_EQ(status.a, 7);
  EXPECT_EQ(status.b, 5);
}

Status checked(int value) {
  ILP_ASSERT(value > 0, value);
  return {};
}

Status forwarded(int value) {
  ILP_TRY(checked(value));
  return StatusCode::not_ready;
}

TEST(Assertion, FailsTheStepAndRemembersThePlace) {
  EXPECT_TRUE(checked(1).ok());
  const Status failed = checked(-3);
  EXPECT_TRUE(failed.is(StatusCode::assertion_failed));
  EXPECT_EQ(failed.b, -3);
  EXPECT_EQ(last_assertion().line, failed.a);
  ASSERT_NE(last_assertion().file, nullptr);
  EXPECT_NE(std::string(last_assertion().file).find("test_status.cpp"), std::string::npos);
}

TEST(Try, ReturnsTheFaultAndNothingElse) {
  EXPECT_TRUE(forwarded(-1).is(StatusCode::assertion_failed));
  EXPECT_TRUE(forwarded(1).is(StatusCode::not_ready));
}

}  // namespace
}  // namespace ilp
