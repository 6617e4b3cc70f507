// Keeps the state of a live flight as named items with versions, so that each page gets only the items that have
// changed since its last answer.
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

/// Key: name, such as "keyframes/12".
using Items = std::map<std::string, nlohmann::ordered_json>;

/// Identifies the state that a page has. As text: `PROCESS-VERSION`.
struct Place {
  std::uint64_t process = 0;  ///< random number of the StateLog
  std::uint64_t version = 0;
};
[[nodiscard]] std::string text_of(const Place& place);
/// Parses the text of a Place; none for any other text.
[[nodiscard]] std::optional<Place> place_of(std::string_view text);

struct Update {
  Place place;            ///< state of a page that has applied the update
  std::string json;       ///< {"full":BOOL,"set":{NAME:ITEM},"gone":[NAME]}; full: the page first removes all its items
  std::size_t items = 0;  ///< number of items in "set" and "gone"
};

/// An update contains each item that has changed since the page's Place once, in its newest version. A slow page
/// therefore skips outdated versions, and nothing is queued for it. May be used by several threads.
class StateLog {
 public:
  StateLog();
  /// Replaces all items except those set by `put`. Returns the update for a page that was up to date.
  Update replace(const Items& items);
  /// Sets one item, which `replace` does not change.
  void put(const std::string& name, const nlohmann::ordered_json& item);
  /// The changes since `place`; all items if it is none or of another process.
  [[nodiscard]] Update since(const std::optional<Place>& place) const;
  /// Waits for a change since `place`, at most for `longest`; ends earlier if `stop` is true when `wake` is called.
  /// Returns false if nothing has changed, or after `end`.
  [[nodiscard]] bool wait(const Place& place, std::chrono::milliseconds longest, const std::atomic<bool>& stop) const;
  void wake();
  /// Ends all present and future waits.
  void end();

 private:
  struct Item {
    std::string json;  ///< empty: the item was removed
    std::uint64_t version = 0;
    bool single = false;  ///< set by `put`
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
