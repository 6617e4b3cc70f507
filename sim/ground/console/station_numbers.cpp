#include "sim/ground/console/station_numbers.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/ground/console/received_file.hpp"

namespace ilp::console {
namespace {

constexpr const char* title = "# numbers that this ground station has reserved: SPI (0: file transactions) and number";
/// This many numbers are reserved in the file at once; a restart skips the unused ones.
constexpr std::uint64_t in_a_reserve = 256;

std::uint64_t calendar_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

}  // namespace

StationNumbers::StationNumbers() = default;

StationNumbers::StationNumbers(std::filesystem::path file) : file_(std::move(file)) {
  const std::string lock = file_.string() + ".lock";
  lock_ = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock_ < 0) throw std::runtime_error(lock + " cannot be written: " + std::strerror(errno));
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    throw std::runtime_error(file_.string() +
                             " is in use by another console: two stations need two keys and two files");
  }
  try {
    read();
    write();
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

StationNumbers::~StationNumbers() {
  if (lock_ >= 0) ::close(lock_);
}

void StationNumbers::read() {
  std::ifstream in(file_);
  if (!in) {
    if (std::filesystem::exists(file_)) throw std::runtime_error(file_.string() + " cannot be read");
    return;
  }
  bool ended = false;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (ended) throw std::runtime_error(file_.string() + " is damaged: there is text after its end");
    ended = line == "end";
    if (ended) continue;
    std::istringstream words(line);
    std::uint64_t which = 0, reserved = 0;
    std::string rest;
    const bool good = words >> which >> reserved && !(words >> rest) && which <= 65535 && line[0] != '-';
    if (!good) throw std::runtime_error(file_.string() + " is damaged: " + line + " is no SPI and number");
    counters_[static_cast<std::uint32_t>(which)] = {reserved, reserved};
  }
  if (!ended) {
    throw std::runtime_error(file_.string() +
                             " is damaged: it is cut short. Without it numbers go on from the calendar");
  }
}

void StationNumbers::write() const {
  if (file_.empty()) return;
  std::string text = std::string(title) + "\n";
  for (const auto& [which, counter] : counters_) {
    text += std::to_string(which) + " " + std::to_string(counter.reserved) + "\n";
  }
  text += "end\n";
  const auto* octets = reinterpret_cast<const std::uint8_t*>(text.data());
  replace_file(file_, {octets, text.size()});
}

std::uint64_t StationNumbers::take(std::uint32_t which, std::uint64_t first, std::uint64_t last) {
  Counter& counter = counters_[which];
  if (counter.next == counter.reserved) {
    const Counter before = counter;
    counter.next = std::max(counter.next, first);
    if (counter.next > last - in_a_reserve) {
      counter = before;
      throw std::runtime_error(which == transactions ? "the numbers of file transactions are used up"
                                                     : "the sequence numbers of SPI " + std::to_string(which) +
                                                           " are used up: the station needs another key");
    }
    counter.reserved = counter.next + in_a_reserve;
    try {
      write();
    } catch (...) {
      counter = before;
      throw;
    }
  }
  return counter.next++;
}

std::uint32_t StationNumbers::next_sequence(std::uint16_t spi) {
  return static_cast<std::uint32_t>(take(spi, calendar_ms() / 1000, std::numeric_limits<std::uint32_t>::max()));
}

std::uint64_t StationNumbers::next_transaction() {
  return take(transactions, calendar_ms(), std::numeric_limits<std::int64_t>::max());
}

}  // namespace ilp::console
