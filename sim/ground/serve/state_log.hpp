// The state of a live flight as items with names, and which of them have changed since the last answer to a page.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace ilp::serve {

/// By name, such as "keyframes/12".
using Items = std::map<std::string, nlohmann::ordered_json>;

/// The state that a page has, in text `PROCESS-VERSION`.
struct Place {
  std::uint64_t process = 0;  ///< drawn for every StateLog
  std::uint64_t version = 0;
};
[[nodiscard]] std::string text_of(const Place& place);
/// None for any other text.
[[nodiscard]] std::optional<Place> place_of(std::string_view text);

struct Update {
  Place place;            ///< the state of a page that has applied it
  std::string json;       ///< {"full":BOOL,"set":{NAME:ITEM},"gone":[NAME]}; full: everything before it is void
  std::size_t items = 0;  ///< in "set" and "gone"
};

/// Every page gets each item that has changed since its place once, in its newest form. A slow page therefore skips
/// what is out of date, and nothing is queued for it. May be used by several threads.
class StateLog {
 public:
  StateLog();
  /// Replaces all items but those of `put`. What a page that was up to date is now sent.
  Update replace(const Items& items);
  /// Sets one item, which `replace` leaves alone.
  void put(const std::string& name, const nlohmann::ordered_json& item);
  /// What is new since `place`; everything if it is none or of another process.
  [[nodiscard]] Update since(const std::optional<Place>& place) const;
  /// Waits until there is something new since `place`, at most for `longest`, and no longer than until `stop` is true
  /// and `wake` is called. False when there is nothing new, or at the end.
  [[nodiscard]] bool wait(const Place& place, std::chrono::milliseconds longest, const std::atomic<bool>& stop) const;
  void wake();
  /// All waiting threads return, and no thread waits any more.
  void end();

 private:
  struct Item {
    std::string json;  ///< empty: the item is gone
    std::uint64_t version = 0;
    bool single = false;  ///< from `put`
  };
  void set(const std::string& name, std::string json, bool single);
  [[nodiscard]] Update update_since(const std::optional<Place>& place) const;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::map<std::string, Item> items_;
  Place newest_;
  bool ended_ = false;
};

}  // namespace ilp::serve
