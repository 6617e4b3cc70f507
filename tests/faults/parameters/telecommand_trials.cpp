// Telecommands at every boundary of every field: for every service and function, data of every length in which a field
// of 1, 2, 4 or 8 octets at every place has the values at which arithmetic goes wrong.
#include <algorithm>
#include <cstdio>
#include <set>

#include "fsw/commanding/function_table.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "tests/faults/parameters/trial_flight.hpp"

namespace ilp::faults {
namespace {

using test::Octets;

struct InOrder {
  bool operator()(const Octets& a, const Octets& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  }
};
using Requests = std::set<Octets, InOrder>;

struct Kind {
  int service = 0, subtype = 0;
  const FunctionInfo* function = nullptr;
};

std::vector<Kind> kinds() {
  std::vector<Kind> list;
  for (const FunctionInfo& function : function_table()) list.push_back({8, 1, &function});
  // Unknown subtypes are refused, and so are unknown services.
  constexpr std::pair<int, int> services[] = {{1, 2}, {2, 2}, {3, 40}, {5, 10}, {11, 30}, {17, 4}, {20, 4}, {255, 2}};
  for (const auto& [service, most] : services) {
    for (int subtype = 0; subtype <= most; ++subtype) list.push_back({service, subtype});
  }
  return list;
}

/// 0, 1, the largest, and both sides of the sign.
std::vector<Octets> boundaries(std::size_t width) {
  Octets zero(width), one(width), most(width, 0xFF), positive(width, 0xFF), negative(width), two(width);
  one.back() = 1;
  two.back() = 2;
  positive.front() = 0x7F;
  negative.front() = 0x80;
  std::vector<Octets> list = {zero, one, two, most, positive, negative};
  // Numbers that are none, infinite, and the smallest there is: an f64.
  if (width == 8) {
    list.push_back({0x7F, 0xF8, 0, 0, 0, 0, 0, 0});
    list.push_back({0x7F, 0xF0, 0, 0, 0, 0, 0, 0});
    list.push_back({0xFF, 0xF0, 0, 0, 0, 0, 0, 0});
  }
  return list;
}

Requests data_at_boundaries(std::size_t length, std::uint8_t rest) {
  Requests list;
  list.insert(Octets(length, rest));
  for (const std::size_t width : {1U, 2U, 4U, 8U}) {
    for (std::size_t at = 0; at + width <= length; ++at) {
      for (const Octets& value : boundaries(width)) {
        Octets data(length, rest);
        std::copy(value.begin(), value.end(), data.begin() + static_cast<std::ptrdiff_t>(at));
        list.insert(data);
      }
    }
  }
  return list;
}

/// Data that begin as a request about one parameter does, for each of them.
void add_parameters(Requests& list) {
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    for (const std::size_t width : {1U, 2U, 4U, 8U}) {
      for (const Octets& value : boundaries(width)) {
        Octets data = console::data_of([&](ByteWriter& out) {
          out.u16(1);
          out.u16(parameter_info(i).number);
        });
        data.insert(data.end(), value.begin(), value.end());
        list.insert(data);
      }
    }
  }
}

Requests requests_of(const Kind& kind) {
  Requests list;
  const std::size_t arguments = kind.function == nullptr ? 14
                                                         : kind.function->bytes + kind.function->optional +
                                                               (kind.function->has_time ? 8U : 0U) + 2U;
  for (std::size_t length = 0; length <= arguments; ++length) {
    for (const std::uint8_t rest : {std::uint8_t{0}, std::uint8_t{1}}) {
      for (const Octets& data : data_at_boundaries(length, rest)) {
        list.insert(kind.function == nullptr ? data : console::function(kind.function->name, data));
      }
    }
  }
  if (kind.service == 20) add_parameters(list);
  return list;
}

Fate fly(const Kind& kind, const std::vector<host::Raster<std::uint8_t>>& images) {
  TrialFlight flight(images);
  test::FlightBoard& board = flight.board();
  if (!board.start().ok()) return Fate::no_start;
  board.fly_on(5);
  int sent = 0;
  for (const Octets& data : requests_of(kind)) {
    flight.send(kind.service, kind.subtype, data);
    // As many as the flight carries out in a minor frame.
    if (++sent % 20 == 0) board.fly_on(0.1);
    if (sent % 2000 == 0 && !board.restart().ok()) return Fate::no_start;
  }
  board.fly_on(10);
  if (!board.restart().ok()) return Fate::no_start;
  board.fly_on(5);
  return flight.reach();
}

std::string text_of(const Kind& kind) {
  if (kind.function != nullptr) return std::string("function ") + kind.function->name;
  return "TC[" + std::to_string(kind.service) + "," + std::to_string(kind.subtype) + "]";
}

}  // namespace

bool telecommand_trials(const CampaignOptions& options) {
  const std::vector<host::Raster<std::uint8_t>> images = trial_images();
  const std::vector<Kind> list = kinds();
  std::size_t requests = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (static_cast<std::int64_t>(i) % options.every == 0) requests += requests_of(list[i]).size();
  }
  std::printf("%zu telecommands\n", requests);
  TrialTable table{.rows = {"functions", "services"}};
  table.trial = [&](std::int64_t trial) { return fly(list[static_cast<std::size_t>(trial)], images); };
  table.describe = [&](std::int64_t trial) {
    const Kind& kind = list[static_cast<std::size_t>(trial)];
    return std::pair<std::size_t, std::string>{kind.function != nullptr ? 0 : 1, text_of(kind)};
  };
  return run_table(table, static_cast<std::int64_t>(list.size()), options);
}

}  // namespace ilp::faults
