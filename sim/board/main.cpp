// ilp-board-station: the ground station of the emulated board. Stores every file that it receives, and reads commands
// from standard input:
//
//   captures FIRST_NS INTERVAL_NS COUNT    schedules COUNT telecommands for a capture each; UTC since 1970
//   end-strip                              sends the telecommand STRIPEND
//   quit
//
// It answers with `scheduled`, `refused` or `strip ended`. It prints `held NAME BYTES CRC32 POSITION` before it
// confirms a file to the board; POSITION is the number of entries in the write log at that time. Every two seconds it
// prints the mission time as `seconds N`, the number of products on board as `products N`, and the number of steps of
// the components that process images as `steps N`. The flight has finished its work when products and steps no longer
// change.

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfg/schedule.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "sim/ground/console/console.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/version_line.hpp"

namespace ilp::board {
namespace {

namespace fs = std::filesystem;
using Bytes = console::Console::Bytes;

constexpr std::size_t captures_in_a_telecommand = 5;
constexpr double patience_s = 60;
constexpr UtcNs utc_of_1970 = 4383 * seconds_per_day * ns_per_s;
// docs/interface-control-document.md, SID 1, 2 and 5
constexpr std::uint64_t status_report = 1, components_report = 2, storage_report = 5;
constexpr std::size_t component_bytes = 32, products_held_offset = 52;

const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);

/// Entries that QEMU has written into the log of the data disk, from its first sector.
std::uint64_t log_entries(const fs::path& log) {
  constexpr std::streamoff count_offset = 16;
  std::uint64_t count = 0;
  std::ifstream in(log, std::ios::binary);
  if (in.seekg(count_offset)) in.read(reinterpret_cast<char*>(&count), sizeof(count));
  return count;
}

class Station {
 public:
  Station(const SocketAddress& board, fs::path folder, fs::path write_log)
      : folder_(std::move(folder)), write_log_(std::move(write_log)), console_(settings(board)) {
    watch();
  }

  /// Until the input says quit or ends.
  void run() {
    std::string line;
    while (read_line(line)) {
      if (!line.empty()) obey(line);
      console_.listen(0.1);
      report_progress();
    }
  }

 private:
  console::ConsoleSettings settings(const SocketAddress& board) {
    console::ConsoleSettings settings;
    settings.transport = console::Transport::tcp;
    settings.board = board;
    settings.keep = [this](const std::string& name, const Bytes& file) { return keep(name, file); };
    return settings;
  }

  bool keep(const std::string& name, const Bytes& file) {
    if (name.empty() || fs::path(name).filename() != name) return false;
    const std::uint64_t position = write_log_.empty() ? 0 : log_entries(write_log_);
    std::ofstream out(folder_ / name, std::ios::binary);
    out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    if (!out.flush()) return false;
    std::cout << "held " << name << " " << file.size() << " " << crc32(file) << " " << position << std::endl;
    return true;
  }

  bool read_line(std::string& line) {
    pollfd wait{STDIN_FILENO, POLLIN, 0};
    line.clear();
    if (poll(&wait, 1, 0) <= 0) return true;
    return static_cast<bool>(std::getline(std::cin, line)) && line != "quit";
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string what;
    words >> what;
    if (what == "captures") {
      UtcNs first = 0;
      TimeNs interval = 0;
      std::size_t count = 0;
      if (words >> first >> interval >> count) schedule(first, interval, count);
    } else if (what == "end-strip") {
      const std::uint32_t request =
          console_.command(function_management::service, function_management::perform, console::function("STRIPEND"));
      answer(request, "strip ended");
    } else {
      throw std::runtime_error("not understood: " + line);
    }
  }

  void answer(std::uint32_t request, const char* good) {
    const bool done = console_.listen(patience_s, [&] { return console_.completed(request); });
    std::cout << (done ? good : "refused") << std::endl;
  }

  void schedule(UtcNs first, TimeNs interval, std::size_t count) {
    for (std::size_t begin = 0; begin < count; begin += captures_in_a_telecommand) {
      const std::size_t end = std::min(begin + captures_in_a_telecommand, count);
      const Bytes data = console::data_of([&](ByteWriter& out) {
        encode_insert_head(tailoring, 0, end - begin, out);
        for (std::size_t i = begin; i < end; ++i) {
          const Bytes packet =
              console_.build(function_management::service, function_management::perform, console::function("CAPTURE"));
          ScheduleItem item;
          item.release = utc_of_1970 + first + static_cast<TimeNs>(i) * interval;
          item.packet = packet;
          host::require(encode_insert_item(tailoring, item, out), "encoding the schedule");
        }
      });
      answer(console_.command(scheduling::service, scheduling::insert, data), "scheduled");
    }
  }

  void watch() {
    IntervalList intervals;
    ReportList list;
    for (const std::uint64_t report : {status_report, components_report, storage_report}) {
      if (!intervals.push_back({report, 2 * ns_per_s}) || !list.push_back(report)) return;
    }
    console_.command(housekeeping::service, housekeeping::set_interval,
                     console::data_of([&](ByteWriter& out) { encode_interval_list(tailoring, intervals, out); }));
    console_.command(housekeeping::service, housekeeping::enable,
                     console::data_of([&](ByteWriter& out) { encode_report_list(tailoring, list, out); }));
  }

  void report_progress() {
    const std::vector<console::Report>& reports = console_.reports();
    for (; reported_ < reports.size(); ++reported_) {
      const console::Report& report = reports[reported_];
      if (report.header.service != housekeeping::service || report.header.subtype != housekeeping::report) continue;
      ByteReader in(report.data);
      const std::uint64_t id = in.number(tailoring.report_id);
      if (id == status_report) std::cout << "seconds " << static_cast<TimeNs>(in.number(8)) / ns_per_s << std::endl;
      if (id == components_report) std::cout << "steps " << steps_on_images(in.rest()) << std::endl;
      if (id != storage_report) continue;
      in.take(products_held_offset);
      std::cout << "products " << in.u32() << std::endl;
    }
  }

  static std::uint64_t steps_on_images(std::span<const std::uint8_t> report) {
    std::uint64_t steps = 0;
    for (const Stage& stage : ilp::schedule) {
      if (stage.period != 0) continue;
      const std::size_t offset = (static_cast<std::size_t>(stage.component) - 1) * component_bytes;
      if (offset < report.size()) steps += ByteReader(report.subspan(offset)).u32();
    }
    return steps;
  }

  fs::path folder_, write_log_;
  std::size_t reported_ = 0;
  console::Console console_;
};

int run(const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0] == "--version") {
    std::cout << host::version_line("ilp-board-station") << "\n";
    return 0;
  }
  const char* const usage =
      "The ground station of the emulated board: keeps every file that comes, and obeys the lines of its input\n"
      "usage: ilp-board-station ADDRESS:PORT FOLDER [WRITE_LOG] | ilp-board-station --version\n"
      "Example: ilp-board-station 127.0.0.1:10025 received\n"
      "Exit status: 0 done, 1 the work could not be done, 2 wrong call\n";
  if (words.size() == 1 && words[0] == "--help") {
    std::cout << usage;
    return 0;
  }
  SocketAddress board;
  if ((words.size() != 2 && words.size() != 3) || !parse_address(words[0].c_str(), board).ok()) {
    std::cerr << usage;
    return 2;
  }
  fs::create_directories(words[1]);
  Station(board, words[1], words.size() == 3 ? words[2] : "").run();
  return 0;
}

}  // namespace
}  // namespace ilp::board

int main(int argc, char** argv) {
  try {
    return ilp::board::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "ilp-board-station: " << error.what() << "\n";
    return 1;
  }
}
