#include "sim/ground/export/body.hpp"

#include <array>

namespace ilp::exports {
namespace {

// The poles of Mars lie 20 km below the sphere that maps of Mars use.
constexpr std::array<Body, 5> all_bodies = {{
    {"mars", "Mars", "IAU_2015:49900", "the IAU 2015 sphere of 3 396 190 m", -25e3, 80e3},
    {"titan", "Titan", "IAU_2015:60600", "the IAU 2015 sphere of 2 575 000 m", -5e3, 200e3},
    {"venus", "Venus", "IAU_2015:29900", "the IAU 2015 sphere of 6 051 800 m", -5e3, 100e3},
    {"moon", "Moon", "IAU_2015:30100", "the IAU 2015 sphere of 1 737 400 m", -15e3, 200e3},
    {"earth", "Earth", "EPSG:4326", "the WGS 84 ellipsoid", -600, 60e3},
}};

}  // namespace

std::span<const Body> bodies() {
  return all_bodies;
}

const Body* find_body(std::string_view key) {
  for (const Body& body : all_bodies) {
    if (key == body.key) return &body;
  }
  return nullptr;
}

std::string body_names() {
  std::string names;
  for (const Body& body : all_bodies) names += (names.empty() ? "" : ", ") + std::string(body.key);
  return names;
}

const Body* flown_body(std::string_view description) {
  constexpr std::string_view before = "scenario ";
  const std::size_t at = description.find(before);
  if (at == std::string_view::npos) return nullptr;
  const std::string_view scenario = description.substr(at + before.size());
  for (const Body& body : all_bodies) {
    if (scenario.starts_with(std::string(body.key) + "-")) return &body;
  }
  return nullptr;
}

}  // namespace ilp::exports
