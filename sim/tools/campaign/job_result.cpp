#include "sim/tools/campaign/job_result.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/host/files.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int version = 1;
constexpr std::uintmax_t largest_file = 64U << 20U;

Json parse_file(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  const std::string name = file.filename().string();
  if (error) throw std::runtime_error("no " + name);
  if (size > largest_file) throw std::runtime_error(name + " is larger than 64 MiB");
  Json json = Json::parse(ground::read_file(file), nullptr, false);
  if (json.is_discarded()) throw std::runtime_error(name + " is not JSON");
  if (!json.is_object()) throw std::runtime_error(name + " is not a JSON object");
  if (json.value("version", Json()) != version) {
    throw std::runtime_error(name + ": expected \"version\": " + std::to_string(version));
  }
  return json;
}

Score score_of(const Json& json, const std::string& name) {
  const auto member = [&](const char* key, bool (Json::*is)() const, const char* expected) -> const Json& {
    const auto found = json.find(key);
    if (found == json.end() || !((*found).*is)()) {
      throw std::runtime_error(name + ": expected \"" + key + "\" to be " + expected);
    }
    return *found;
  };
  Score score;
  score.complete = member("complete", &Json::is_boolean, "true or false").get<bool>();
  for (const auto& [key, value] : member("summary", &Json::is_object, "an object").items()) {
    if (!value.is_null() && !value.is_number()) {
      throw std::runtime_error(
          std::string(name).append(": expected \"summary\" \"").append(key).append("\" to be a number or null"));
    }
    auto& field = score.summary[key];
    if (value.is_number() && std::isfinite(value.get<double>())) field = value.get<double>();
  }
  if (!json.contains("remarks")) return score;
  for (const Json& remark : member("remarks", &Json::is_array, "a list")) {
    score.remarks.push_back(remark.is_string() ? remark.get<std::string>() : remark.dump());
  }
  return score;
}

}  // namespace

Score read_score(const fs::path& file) {
  return score_of(parse_file(file), file.filename().string());
}

void write_result(const fs::path& file, const JobResult& result) {
  Json summary = Json::object();
  for (const auto& [key, value] : result.score.summary) summary[key] = value ? Json(*value) : Json();
  const Json json = {{"version", version},
                     {"digest", result.digest},
                     {"failure", result.failure},
                     {"seconds", result.seconds},
                     {"complete", result.score.complete},
                     {"summary", summary},
                     {"remarks", result.score.remarks}};
  // What a program has printed need not be UTF-8.
  ground::write_file(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<JobResult> read_result(const fs::path& file) {
  try {
    const Json json = parse_file(file);
    JobResult result;
    result.score = score_of(json, file.filename().string());
    result.digest = json.at("digest").get<std::string>();
    result.failure = json.at("failure").get<std::string>();
    result.seconds = json.at("seconds").get<double>();
    return result;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace ilp::batch
