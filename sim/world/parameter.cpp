#include "sim/world/parameter.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "sim/host/text_format.hpp"

namespace ilp::world {
namespace {

constexpr double radians_per_degree = 0.017453292519943295;

std::string full_name(std::string_view section, std::string_view name) {
  return "[" + std::string(section) + "] " + std::string(name);
}

[[noreturn]] void refuse(const Parameter& parameter, std::string_view section, const std::string& given,
                         const std::string& expected) {
  throw std::invalid_argument(full_name(section, parameter.name) + " = " + given + ": expected " + expected);
}

template <typename Number>
Number parse(const Parameter& parameter, std::string_view section, std::string_view text, const char* kind) {
  Number value{};
  const std::string_view given = text;
  const bool angle = std::is_floating_point_v<Number> && parameter.unit == "rad";
  const bool degrees = angle && text.ends_with("deg");
  if (degrees) text.remove_suffix(3);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  bool right = error == std::errc{} && end == text.data() + text.size();
  if constexpr (std::is_floating_point_v<Number>) {
    right = right && std::isfinite(value);
    if (degrees) value *= radians_per_degree;
  }
  const auto as_double = static_cast<double>(value);
  if (!right || as_double < parameter.lowest || as_double > parameter.highest) {
    refuse(parameter, section, std::string(given),
           kind + range_text(parameter) + (angle ? ", or degrees, written 90deg" : ""));
  }
  return value;
}

}  // namespace

std::string number_text(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return {text, end};
}

std::string range_text(const Parameter& parameter) {
  constexpr double limit = std::numeric_limits<double>::max();
  std::string text;
  if (parameter.lowest > -limit) text += " from " + number_text(parameter.lowest);
  if (parameter.highest < limit) text += " to " + number_text(parameter.highest);
  if (!parameter.unit.empty()) text += " " + std::string(parameter.unit);
  return text;
}

void set_parameter(const std::vector<Parameter>& parameters, std::string_view section, std::string_view name,
                   std::string_view text) {
  for (const Parameter& parameter : parameters) {
    if (parameter.name != name) continue;
    std::visit(
        [&](auto* field) {
          using Field = std::remove_pointer_t<decltype(field)>;
          if constexpr (std::is_same_v<Field, std::string>) {
            *field = text;
          } else if constexpr (std::is_same_v<Field, Lens>) {
            const EnumValue* const value = find_value(values_of(Lens{}), std::string(text).c_str());
            if (value == nullptr) refuse(parameter, section, std::string(text), "brown or fisheye");
            *field = static_cast<Lens>(value->number);
          } else if constexpr (std::is_same_v<Field, bool>) {
            if (text != "true" && text != "false") refuse(parameter, section, std::string(text), "true or false");
            *field = text == "true";
          } else if constexpr (std::is_same_v<Field, double>) {
            *field = parse<double>(parameter, section, text, "a number");
          } else {
            *field = parse<Field>(parameter, section, text, "a whole number");
          }
        },
        parameter.field);
    return;
  }
  std::string known;
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) {
    known += (known.empty() ? "" : ", ") + std::string(parameter.name);
    names.emplace_back(parameter.name);
  }
  throw std::invalid_argument(full_name(section, name) + ": no such parameter; there are " + known +
                              host::did_you_mean(std::string(name), names));
}

std::string parameter_text(const Parameter& parameter) {
  return std::visit(
      [](const auto* field) -> std::string {
        using Field = std::remove_cv_t<std::remove_pointer_t<decltype(field)>>;
        if constexpr (std::is_same_v<Field, std::string>) {
          return *field;
        } else if constexpr (std::is_same_v<Field, Lens>) {
          return name_of(*field);
        } else if constexpr (std::is_same_v<Field, bool>) {
          return *field ? "true" : "false";
        } else if constexpr (std::is_same_v<Field, double>) {
          return number_text(*field);
        } else {
          return std::to_string(*field);
        }
      },
      parameter.field);
}

void check_parameters(const std::vector<Parameter>& parameters, std::string_view section) {
  for (const Parameter& parameter : parameters) {
    std::visit(
        [&](const auto* field) {
          using Field = std::remove_cv_t<std::remove_pointer_t<decltype(field)>>;
          if constexpr (!std::is_same_v<Field, std::string> && !std::is_same_v<Field, bool> &&
                        !std::is_same_v<Field, Lens>) {
            const auto value = static_cast<double>(*field);
            if (!(value >= parameter.lowest && value <= parameter.highest)) {
              refuse(parameter, section, parameter_text(parameter), "a number" + range_text(parameter));
            }
          }
        },
        parameter.field);
  }
}

}  // namespace ilp::world
