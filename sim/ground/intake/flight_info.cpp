#include "sim/ground/intake/flight_info.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/host/files.hpp"

namespace ilp::intake {

FlightInfo read_flight_info(const std::filesystem::path& path) {
  const nlohmann::json json = nlohmann::json::parse(host::read_file(path), nullptr, false);
  if (!json.is_object()) throw std::runtime_error(path.string() + " is not a JSON object");
  const auto number = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
  };
  const auto text = [&json](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  FlightInfo info;
  info.wall_s = number("wall_s");
  info.cpu_s = number("cpu_s");
  info.flight_cpu_s = number("flight_software_cpu_s");
  info.peak_rss_mib = number("peak_rss_mib");
  info.static_bytes = number("static_bytes");
  info.frames = number("frames");
  info.keyframes = number("keyframes");
  info.seed = number("seed");
  info.target_overlap = number("target_overlap");
  info.profile = text("profile");
  info.software = text("software");
  info.source = text("source");
  return info;
}

}  // namespace ilp::intake
