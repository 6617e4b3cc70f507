#include "sim/ground/serve/state_log.hpp"

#include <charconv>
#include <nlohmann/json.hpp>
#include <random>

namespace ilp::serve {
namespace {

// What came down may be no UTF-8.
std::string json_text(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool read_number(std::string_view text, int base, std::uint64_t& number) {
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return !text.empty() && end.ec == std::errc() && end.ptr == text.data() + text.size();
}

}  // namespace

std::string text_of(const Place& place) {
  char process[17] = {};
  *std::to_chars(process, process + 16, place.process, 16).ptr = 0;
  return std::string(process) + "-" + std::to_string(place.version);
}

std::optional<Place> place_of(std::string_view text) {
  const std::size_t dash = text.find('-');
  Place place;
  if (dash == std::string_view::npos || !read_number(text.substr(0, dash), 16, place.process) ||
      !read_number(text.substr(dash + 1), 10, place.version)) {
    return std::nullopt;
  }
  return place;
}

StateLog::StateLog() {
  std::random_device random;
  newest_.process = std::uint64_t{random()} << 32U | random();
}

void StateLog::set(const std::string& name, std::string json, bool single) {
  Item& item = items_[name];
  item.single = single;
  if (item.version != 0 && item.json == json) return;
  item.json = std::move(json);
  item.version = newest_.version + 1;
}

Update StateLog::replace(const Items& items) {
  const std::lock_guard lock(mutex_);
  const Place before = newest_;
  for (const auto& [name, item] : items) set(name, json_text(item), false);
  for (auto& [name, item] : items_) {
    if (!item.single && !item.json.empty() && !items.contains(name)) item = {"", newest_.version + 1, false};
  }
  ++newest_.version;
  changed_.notify_all();
  return update_since(before);
}

void StateLog::put(const std::string& name, const nlohmann::ordered_json& item) {
  const std::lock_guard lock(mutex_);
  set(name, json_text(item), true);
  ++newest_.version;
  changed_.notify_all();
}

Update StateLog::since(const std::optional<Place>& place) const {
  const std::lock_guard lock(mutex_);
  return update_since(place);
}

Update StateLog::update_since(const std::optional<Place>& place) const {
  const bool full = !place || place->process != newest_.process || place->version > newest_.version;
  const std::uint64_t version = full ? 0 : place->version;
  std::string set, gone;
  std::size_t items = 0;
  for (const auto& [name, item] : items_) {
    if (item.version <= version || (full && item.json.empty())) continue;
    ++items;
    std::string& list = item.json.empty() ? gone : set;
    list += (list.empty() ? "" : ",") + json_text(name);
    if (!item.json.empty()) list += ":" + item.json;
  }
  return {newest_,
          R"({"full":)" + std::string(full ? "true" : "false") + R"(,"set":{)" + set + R"(},"gone":[)" + gone + "]}",
          items};
}

bool StateLog::wait(const Place& place, std::chrono::milliseconds longest, const std::atomic<bool>& stop) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, longest, [&] { return ended_ || stop || newest_.version != place.version; });
  return !ended_ && newest_.version != place.version;
}

void StateLog::wake() {
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

void StateLog::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

}  // namespace ilp::serve
