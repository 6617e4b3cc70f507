#include "cfg/mission.hpp"

#include <cmath>
#include <cstring>
#include <iterator>
#include <type_traits>

#include "cfg/relations.hpp"
#include "cfg/schedule.hpp"

namespace ilp {
namespace {

template <typename Value>
constexpr FieldType stored_as() {
  if constexpr (std::is_same_v<Value, bool>) {
    return FieldType::u8;
  } else {
    return detail::field_type<Value>();
  }
}

constexpr FieldType link_f64 = FieldType::f64, link_u8 = FieldType::u8, link_u16 = FieldType::u16;
constexpr FieldType link_u32 = FieldType::u32, link_rounded_u32 = FieldType::u32;

constexpr ParameterInfo infos[] = {
#define ROW(number, section, key, type, unit, minimum, maximum, choices, acts, meaning) \
  {number,                                                                              \
   #section,                                                                            \
   #key,                                                                                \
   offsetof(MissionParameters, key),                                                    \
   stored_as<decltype(MissionParameters::key)>(),                                       \
   type,                                                                                \
   unit,                                                                                \
   minimum,                                                                             \
   maximum,                                                                             \
   choices,                                                                             \
   Acts::acts,                                                                          \
   meaning},
#define QUANTITY(number, section, key, type, unit, minimum, maximum, value, acts, meaning) \
  ROW(number, section, key, link_##type, unit, minimum, maximum, EnumValues{}, acts, meaning)
#define CHOICE(number, section, key, enumeration, value, acts, meaning)                  \
  ROW(number, section, key, link_u8, "", 0, static_cast<double>(enumeration::count) - 1, \
      values_of(enumeration::value), acts, meaning)
#define FLAG(number, section, key, value, acts, meaning) \
  ROW(number, section, key, link_u8, "", 0, 1, EnumValues(boolean_values), acts, meaning)
#include "cfg/parameters.inc"
#undef FLAG
#undef CHOICE
#undef QUANTITY
#undef ROW
};

constexpr bool rows_are_valid() {
  for (std::size_t i = 0; i < std::size(infos); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (infos[i].number == infos[k].number) return false;
    }
    const std::size_t bits = 8 * element_bytes(infos[i].stored);
    const double most = bits == 64 ? infos[i].maximum : static_cast<double>((std::uint64_t{1} << bits) - 1);
    if (!(infos[i].minimum <= infos[i].maximum && infos[i].maximum <= most)) return false;
  }
  return true;
}
static_assert(rows_are_valid(), "a number of a parameter is there twice, or a range exceeds its type");

constexpr double minor_frame_s = 1e-9 * static_cast<double>(minor_frame_ns);

template <typename Value>
double value_at(const void* place) {
  Value value;
  std::memcpy(&value, place, sizeof(value));
  return static_cast<double>(value);
}

template <typename Value>
void set_value_at(void* place, double number) {
  const auto value = static_cast<Value>(number);
  std::memcpy(place, &value, sizeof(value));
}

bool fits(const ParameterInfo& info, double value) {
  // NaN is outside of every range.
  if (!(value >= info.minimum && value <= info.maximum)) return false;
  if (info.stored != FieldType::f64 && value != std::floor(value)) return false;
  return info.choices.empty() || find_value(info.choices, static_cast<std::uint64_t>(value)) != nullptr;
}

}  // namespace

std::size_t parameter_count() {
  return std::size(infos);
}
const ParameterInfo& parameter_info(std::size_t index) {
  return infos[index];
}

std::size_t find_parameter(std::uint64_t number) {
  std::size_t i = 0;
  while (i < std::size(infos) && infos[i].number != number) ++i;
  return i;
}

std::size_t find_parameter(const char* section, const char* key) {
  std::size_t i = 0;
  while (i < std::size(infos) && (std::strcmp(infos[i].section, section) != 0 || std::strcmp(infos[i].key, key) != 0)) {
    ++i;
  }
  return i;
}

double parameter_value(const MissionParameters& mission, std::size_t index) {
  const ParameterInfo& info = infos[index];
  const void* const place = reinterpret_cast<const unsigned char*>(&mission) + info.offset;
  switch (element_bytes(info.stored)) {
    case 1:
      return value_at<std::uint8_t>(place);
    case 2:
      return value_at<std::uint16_t>(place);
    case 4:
      return value_at<std::uint32_t>(place);
    default:
      return value_at<double>(place);
  }
}

Status set_parameter(MissionParameters& mission, std::size_t index, double value) {
  if (index >= std::size(infos)) return {StatusCode::not_found, static_cast<std::int64_t>(index)};
  const ParameterInfo& info = infos[index];
  if (!fits(info, value)) return {StatusCode::parameter_out_of_range, info.number};
  void* const place = reinterpret_cast<unsigned char*>(&mission) + info.offset;
  switch (element_bytes(info.stored)) {
    case 1:
      set_value_at<std::uint8_t>(place, value);
      return {};
    case 2:
      set_value_at<std::uint16_t>(place, value);
      return {};
    case 4:
      set_value_at<std::uint32_t>(place, value);
      return {};
    default:
      set_value_at<double>(place, value);
      return {};
  }
}

Status set_parameter(MissionParameters& mission, const char* section, const char* key, double value) {
  const std::size_t index = find_parameter(section, key);
  return index < std::size(infos) ? set_parameter(mission, index, value) : Status{StatusCode::not_found};
}

Status validate(const MissionParameters& mission) {
  if (mission.min_overlap >= mission.target_overlap) return contradiction(Relation::overlaps);
  if (mission.image_bpp_floor > mission.image_bpp_ceiling) return contradiction(Relation::image_bits);
  if (mission.depth_bpp_floor > mission.depth_bpp_ceiling) return contradiction(Relation::depth_bits);
  if (mission.capture_safe_interval_s < mission.capture_min_interval_s ||
      mission.capture_max_interval_s < mission.capture_safe_interval_s) {
    return contradiction(Relation::capture_intervals);
  }
  if (mission.pass_period_s > 0 && mission.pass_length_s > mission.pass_period_s) {
    return contradiction(Relation::passes);
  }
  if (mission.low_watermark >= mission.high_watermark) return contradiction(Relation::watermarks);
  const double weights = mission.gradient_fine_weight + mission.gradient_coarse_weight + mission.entropy_weight +
                         mission.contrast_weight + mission.relief_weight + mission.slope_steep_weight +
                         mission.slope_excess_weight + mission.roughness_fine_weight + mission.roughness_coarse_weight +
                         mission.curvature_weight + mission.novelty_weight;
  if (!(weights > 0)) return contradiction(Relation::weights);
  const unsigned octets = mission.cfdp_sequence_octets;
  if (octets != 1 && octets != 2 && octets != 4 && octets != 8) return contradiction(Relation::sequence_octets);
  if (mission.window_keyframes == 1 || mission.window_keyframes == 2) return contradiction(Relation::window);
  for (const double interval_s : {mission.capture_interval_s, mission.housekeeping_period_s, mission.cfdp_prompt_s,
                                  mission.confirmation_timeout_s}) {
    if (interval_s != 0 && interval_s < minor_frame_s) return contradiction(Relation::minor_frame);
  }
  if (mission.capture_interval_s != 0 && mission.capture_interval_s < mission.capture_min_interval_s) {
    return contradiction(Relation::capture_interval);
  }
  return {};
}

std::uint32_t window_length(const MissionParameters& mission) {
  constexpr auto longest = static_cast<std::uint32_t>(limits::max_window_keyframes);
  if (mission.window_keyframes >= 3) return mission.window_keyframes;
  const double derived = std::ceil(1.0 / (1.0 - mission.target_overlap) - 1e-9);
  const double bounded = derived < 5 ? 5 : derived;
  return bounded > longest ? longest : static_cast<std::uint32_t>(bounded);
}

}  // namespace ilp
