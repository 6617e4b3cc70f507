// Numbers that go over the link or last in a store: the meaning of a number never changes.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "cfg/mission.hpp"
#include "cfg/relations.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/argument.hpp"
#include "fsw/base/status.hpp"
#include "fsw/commanding/function_table.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

/// By kind ("event", "parameter", ...): what each number means.
using Numbers = std::map<std::string, std::map<std::uint64_t, std::string>>;

/// numbers.txt: kind, number, name, and "retired" after a name that is not used any more.
struct Committed {
  Numbers numbers;
  std::set<std::string> retired;  ///< "kind name"
};

Committed committed() {
  Committed list;
  std::ifstream file(ILP_NUMBERS);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string kind, name, state;
    std::uint64_t number = 0;
    words >> kind >> number >> name >> state;
    EXPECT_FALSE(words.bad() || name.empty()) << line;
    EXPECT_TRUE(list.numbers[kind].emplace(number, name).second) << kind << " " << number << " is given twice";
    if (state == "retired") list.retired.insert(kind + " " + name);
  }
  return list;
}

Numbers in_force() {
  Numbers numbers;
  for (std::uint64_t code = 0; code < status_code_limit; ++code) {
    if (is_status_code(code)) numbers["event"][code] = status_name(static_cast<StatusCode>(code));
  }
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    numbers["parameter"][info.number] = std::string(info.section) + "." + info.key;
  }
  for (const ReportInfo& report : report_table()) numbers["report"][report.id] = report.name;
  for (const FunctionInfo& function : function_table()) {
    numbers["function"][static_cast<std::uint64_t>(function.function)] = function.name;
  }
  for (const Stage& stage : schedule) numbers["component"][static_cast<std::uint64_t>(stage.component)] = stage.name;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    numbers["record"][t] = record_info(static_cast<RecordType>(t)).name;
  }
  for (const EnumValue& value : values_of(Argument{})) numbers["argument"][value.number] = value.name;
  for (const EnumValue& value : values_of(Relation{})) numbers["relation"][value.number] = value.name;
  return numbers;
}

TEST(Numbers, AreThoseOfTheCommittedList) {
  const Committed list = committed();
  for (const auto& [kind, rows] : in_force()) {
    const auto known = list.numbers.find(kind);
    ASSERT_NE(known, list.numbers.end()) << "no " << kind << " in " << ILP_NUMBERS;
    for (const auto& [number, name] : rows) {
      const auto row = known->second.find(number);
      ASSERT_NE(row, known->second.end())
          << kind << " " << number << " " << name << " is new: add it to the end of its part of " << ILP_NUMBERS;
      EXPECT_EQ(row->second, name) << kind << " " << number << " is taken";
      EXPECT_EQ(list.retired.count(kind + " " + name), 0U) << kind << " " << name << " is retired";
    }
  }
}

TEST(Numbers, WhatIsGoneKeepsItsNumber) {
  const Committed list = committed();
  const Numbers now = in_force();
  for (const auto& [kind, rows] : list.numbers) {
    const auto& used = now.at(kind);
    for (const auto& [number, name] : rows) {
      const bool retired = list.retired.count(kind + " " + name) != 0;
      EXPECT_NE(used.count(number) != 0, retired)
          << kind << " " << number << " " << name << ": write retired behind it, and leave the line";
    }
  }
}

}  // namespace
}  // namespace ilp
