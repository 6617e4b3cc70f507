#include "sim/sil/power_cut.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "fsw/base/rng.hpp"

namespace ilp::sil {
namespace {

// A keyframe's way to the ground takes about a hundred writes.
constexpr std::uint32_t most_writes = 100;
constexpr std::uint64_t stream = 0x706F776572ULL;

std::vector<std::string> own_arguments() {
  std::ifstream in("/proc/self/cmdline", std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::vector<std::string> arguments;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find('\0', begin), all.size());
    arguments.push_back(all.substr(begin, end - begin));
    begin = end + 1;
  }
  return arguments;
}

}  // namespace

PastBoots read_past_boots(const std::filesystem::path& folder) {
  std::ifstream in(folder / "power.json");
  if (!in) return {};
  const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  try {
    return {json.at("random_cuts"), json.at("timed_cuts"), json.at("clock_ns"), json.at("store_refused"),
            json.at("link_refused")};
  } catch (const nlohmann::json::exception&) {
    throw std::runtime_error((folder / "power.json").string() + " is damaged: expected what a power cut left there");
  }
}

std::vector<PowerCut> plan_power_cuts(int cuts, std::uint64_t seed, std::int64_t frames) {
  Rng random(seed, stream);
  std::vector<PowerCut> plan;
  for (int i = 0; i < cuts; ++i) {
    const std::int64_t sequence = random.below(static_cast<std::uint32_t>(frames));
    plan.push_back({sequence, random.below(most_writes)});
  }
  std::stable_sort(plan.begin(), plan.end(),
                   [](const PowerCut& a, const PowerCut& b) { return a.sequence < b.sequence; });
  return plan;
}

void cut_power(const std::filesystem::path& folder, const PastBoots& boots) {
  const nlohmann::json json = {{"random_cuts", boots.random_cuts},
                               {"timed_cuts", boots.timed_cuts},
                               {"clock_ns", boots.clock_ns},
                               {"store_refused", boots.store_refused},
                               {"link_refused", boots.link_refused}};
  std::ofstream(folder / "power.json") << json.dump(2) << "\n";
  std::cerr << "Power cut at " << static_cast<double>(boots.clock_ns) / static_cast<double>(ns_per_s) << " s\n";
  std::vector<std::string> arguments = own_arguments();
  if (std::find(arguments.begin(), arguments.end(), "--resume") == arguments.end()) arguments.emplace_back("--resume");
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv("/proc/self/exe", words.data());
  std::perror("ilp-sil: cannot start again after the power cut");
  std::_Exit(9);
}

}  // namespace ilp::sil
