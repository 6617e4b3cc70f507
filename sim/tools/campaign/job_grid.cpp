#include "sim/tools/campaign/job_grid.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "sim/host/digest.hpp"
#include "sim/host/safe_name.hpp"

namespace ilp::batch {
namespace {

constexpr std::size_t longest_name = 100;

/// Distinct axes and values give distinct names: what is not shown as it is comes in as a digest.
std::string job_name(const Grid& grid, const Job& job) {
  std::string shown, exact = grid.name;
  for (const auto& [key, value] : job.axes) {
    const std::string last = key.substr(key.find('.') + 1);
    const auto same_last = std::count_if(grid.axes.begin(), grid.axes.end(), [&](const Axis& axis) {
      return axis.key.substr(axis.key.find('.') + 1) == last;
    });
    const bool bare = key == "scenario";
    const std::string text = (bare ? "" : (same_last > 1 ? key : last) + "=") +
                             (bare && is_scenario_file(value) ? std::filesystem::path(value).stem().string() : value);
    if (!shown.empty()) shown += '_';
    shown += text;
    exact.append("\n").append(key).append("=").append(value);
  }
  if (!grid.name.empty()) shown.insert(0, grid.name + "+");
  constexpr const char* kept = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-+=";
  bool faithful = shown.size() <= longest_name && shown[0] != '.' && shown[0] != '-' &&
                  std::none_of(job.axes.begin(), job.axes.end(), [](const auto& axis) {
                    return axis.second.find_first_of("_+") != std::string::npos || is_scenario_file(axis.second);
                  });
  std::string name = shown.substr(0, longest_name);
  for (char& c : name) {
    if (std::string_view(kept).find(c) != std::string_view::npos) continue;
    c = '-';
    faithful = false;
  }
  if (name[0] == '.' || name[0] == '-') name.insert(0, "_");
  return faithful ? name : name + "~" + sim::digest_text(sim::digest(exact)).substr(0, 8);
}

void apply(const Campaign& campaign, const std::string& key, const std::string& value, Job& job,
           std::map<std::string, std::string>& settings) {
  if (key == "scenario") {
    job.scenario = is_scenario_file(value)
                       ? std::filesystem::absolute(campaign.file.parent_path() / value).lexically_normal().string()
                       : value;
  } else if (key == "seed") {
    job.seed = std::stoull(value);
  } else if (key == "frames") {
    job.frames = std::stoi(value);
  } else {
    settings[key] = value;
  }
}

Job job_at(const Campaign& campaign, const Grid& grid, std::size_t index) {
  Job job;
  job.grid = grid.name;
  job.frames = campaign.frames;
  job.axes.resize(grid.axes.size());
  for (std::size_t i = grid.axes.size(); i-- > 0;) {
    const Axis& axis = grid.axes[i];
    job.axes[i] = {axis.key, axis.values[index % axis.values.size()]};
    index /= axis.values.size();
  }
  std::map<std::string, std::string> settings;
  for (const Setting& setting : campaign.settings) apply(campaign, setting.key, setting.value, job, settings);
  for (const auto& [key, value] : job.axes) apply(campaign, key, value, job, settings);
  job.settings.assign(settings.begin(), settings.end());
  job.name = job_name(grid, job);
  return job;
}

}  // namespace

std::vector<Job> expand(const Campaign& campaign) {
  std::vector<Job> jobs;
  for (const Grid& grid : campaign.grids) {
    std::size_t count = 1;
    for (const Axis& axis : grid.axes) {
      count *= axis.values.size();
      if (jobs.size() + count > most_jobs) {
        throw std::runtime_error(campaign.file.string() + ":" + std::to_string(axis.line) +
                                 ": with this axis there are more than " + std::to_string(most_jobs) +
                                 " flights: expected fewer values or axes");
      }
    }
    for (std::size_t i = 0; i < count; ++i) jobs.push_back(job_at(campaign, grid, i));
  }
  return jobs;
}

std::vector<std::string> flight_arguments(const Job& job) {
  std::vector<std::string> arguments;
  if (!job.scenario.empty()) arguments.insert(arguments.end(), {"--scenario", job.scenario});
  for (const auto& [key, value] : job.settings) {
    arguments.emplace_back("--set");
    arguments.emplace_back(key).append("=").append(value);
  }
  arguments.insert(arguments.end(), {"--seed", std::to_string(job.seed)});
  if (job.frames > 0) arguments.insert(arguments.end(), {"--frames", std::to_string(job.frames)});
  return arguments;
}

const std::string* axis_value(const Job& job, const std::string& key) {
  const auto found =
      std::find_if(job.axes.begin(), job.axes.end(), [&](const auto& axis) { return axis.first == key; });
  return found == job.axes.end() ? nullptr : &found->second;
}

std::vector<std::pair<std::string, std::string>> cell_of(const Job& job) {
  std::vector<std::pair<std::string, std::string>> cell;
  std::copy_if(job.axes.begin(), job.axes.end(), std::back_inserter(cell),
               [](const auto& axis) { return axis.first != "seed"; });
  return cell;
}

}  // namespace ilp::batch
