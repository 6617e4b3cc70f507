// Reports of the flight in words for the operator.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/ground/console/console.hpp"

namespace ilp::console {

/// An event of service 5: severity, component, meaning, and what to do (docs/events.md).
[[nodiscard]] std::string event_words(const Tailoring& tailoring, const Report& report);

/// `section.key = value unit` of each parameter of TM[20,2]; `see` is told its number, from 0, and its value.
[[nodiscard]] std::vector<std::string> parameter_words(
    const Tailoring& tailoring, const Report& report,
    const std::function<void(std::size_t index, double value)>& see = {});

/// TM[11,13]: release time and name of each request that waits, by `name_of` where the request is ours.
[[nodiscard]] std::vector<std::string> schedule_words(const Tailoring& tailoring, const Report& report,
                                                      const std::function<std::string(std::uint32_t request)>& name_of);

/// The reason in a failure report of service 1, and what to do about it.
[[nodiscard]] std::string failure_words(std::uint32_t code, std::span<const std::uint8_t> failure_data);

}  // namespace ilp::console
