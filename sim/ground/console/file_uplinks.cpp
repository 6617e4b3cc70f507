#include "sim/ground/console/file_uplinks.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "cfg/limits.hpp"
#include "fsw/downlink/map_uplink.hpp"
#include "fsw/records/records.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "sim/host/mission_input.hpp"

namespace ilp::console {
namespace fs = std::filesystem;
namespace {

/// The size of a file that the flight can take; std::runtime_error for another one.
std::uintmax_t checked_size(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (size == 0 || error) throw std::runtime_error(path.string() + " is not a file, or is empty");
  if (size > limits::max_uplink_bytes) {
    throw std::runtime_error(path.string() + " has " + std::to_string(size) + " bytes, the flight takes at most " +
                             std::to_string(limits::max_uplink_bytes));
  }
  const std::string name = path.filename().string();
  if (name.size() >= sizeof(UplinkRecord::name)) throw std::runtime_error(name + " is too long for a name on board");
  return size;
}

Console::Bytes read_file(const fs::path& path) {
  const std::uintmax_t size = checked_size(path);
  std::ifstream in(path, std::ios::binary);
  Console::Bytes bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (bytes.size() != size) throw std::runtime_error(path.string() + " cannot be read");
  return bytes;
}

/// The flight takes every file for parameters whose name is not one of a map; wrong ones are refused here.
void check_content(const fs::path& path) {
  (void)checked_size(path);
  if (!is_map_file(path.filename().c_str())) host::check_mission_lines(path.string());
}

/// The directory comes first: the flight takes only tiles that it names.
std::deque<fs::path> files_of_map(const fs::path& folder) {
  if (!fs::is_regular_file(folder / map_directory_name)) {
    throw std::runtime_error(folder.string() + " is no folder of a map: there is no " + map_directory_name +
                             " in it (ilp-ground map-tiles makes it)");
  }
  std::deque<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".ilpt") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  files.push_front(folder / map_directory_name);
  return files;
}

}  // namespace

void FileUplinks::put_first(Order& order) {
  const fs::path& file = order.files.front();
  order.transaction = console_.put_file(file.filename().string(), read_file(file));
}

void FileUplinks::send(const fs::path& path, const std::string& words) {
  Order order{words, {path}, 0};
  if (fs::is_directory(path)) order.files = files_of_map(path);
  for (const fs::path& file : order.files) check_content(file);
  put_first(order);
  const std::size_t files = order.files.size();
  orders_.push_back(std::move(order));
  say_("sent: " + words + (files > 1 ? ": " + std::to_string(files) + " files, one after another" : std::string()));
}

bool FileUplinks::is_over(Order& order) {
  using State = ground_cfdp::CfdpSender::State;
  const ground_cfdp::CfdpSender::Transfer& transfer = console_.transfer(order.transaction);
  if (transfer.state == State::going) return false;
  if (transfer.state != State::retained) {
    ++failures_;
    say_("failed: " + order.words + ": the flight has not taken " + order.files.front().filename().string() +
         " (condition " + std::to_string(static_cast<int>(transfer.condition)) +
         "); the event uplink_rejected or map_file_refused says why" +
         (order.files.size() > 1 ? "; the files after it were not sent" : ""));
    return true;
  }
  order.files.pop_front();
  if (order.files.empty()) {
    say_("done: " + order.words + ": the flight holds it");
    return true;
  }
  try {
    put_first(order);
    return false;
  } catch (const std::runtime_error& error) {
    ++failures_;
    say_("failed: " + order.words + ": " + error.what());
    return true;
  }
}

void FileUplinks::watch() {
  std::erase_if(orders_, [this](Order& order) { return is_over(order); });
}

std::vector<std::string> FileUplinks::waiting() const {
  std::vector<std::string> words;
  for (const Order& order : orders_) words.push_back(order.words);
  return words;
}

}  // namespace ilp::console
