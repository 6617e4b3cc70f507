// The operator's side of the link: sends commands that are typed as lines, and shows their reports, events,
// housekeeping and files.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/console/console.hpp"
#include "sim/ground/console/file_uplinks.hpp"
#include "sim/ground/console/flight_view.hpp"
#include "sim/ground/console/operator_command.hpp"

namespace ilp::console {

/// Whether PDUs are authenticated.
enum class SealFiles : std::uint8_t {
  as_reported,  ///< as the flight's parameter `link.authentication` says; until it is known they are not
  no,
  yes
};

struct OperatorSettings {
  ConsoleSettings link;
  std::filesystem::path out;       ///< for files that come; empty: this station takes none
  TimeNs interval = 2 * ns_per_s;  ///< of housekeeping
  SealFiles seal_files = SealFiles::as_reported;
};

class OperatorConsole {
 public:
  /// A line for the operator.
  using Say = std::function<void(const std::string&)>;

  /// Asks for housekeeping and parameters, and again until they come. Throws std::runtime_error when there is no
  /// connection (TCP) or the folder cannot be written.
  OperatorConsole(OperatorSettings settings, Say say);

  /// Executes a line of the operator.
  void enter(const std::string& line);
  /// The two halves of `enter`. Both throw std::runtime_error that says what is wrong.
  [[nodiscard]] OperatorCommand parse(const std::string& line) const;
  void execute(const OperatorCommand& command);
  /// Listens for this long and shows what it receives.
  void step(double seconds);

  [[nodiscard]] const FlightView& view() const { return view_; }
  /// Telecommands and files of the operator that wait for their last report, as they were typed.
  [[nodiscard]] std::vector<std::string> waiting() const;
  /// Lines that were refused, here or on board.
  [[nodiscard]] std::size_t failures() const { return failures_ + uplinks_.failures(); }
  [[nodiscard]] bool wants_to_quit() const { return quit_; }
  [[nodiscard]] double pause_s() const { return pause_s_; }  ///< asked for by the last line
  [[nodiscard]] bool closed() const { return console_.closed(); }
  /// Why nothing may have come, and what to do.
  [[nodiscard]] std::string silence_words() const;

 private:
  struct Request {
    std::string words;
    OperatorCommand command;
    double sent_s = 0;
    bool own = false;       ///< sent by the console itself: reported only if it fails
    bool received = false;  ///< a report about it has come, or its absence was reported
  };

  void send(const OperatorCommand& command, bool own);
  void watch_receiver();
  void follow_authentication();
  void subscribe();
  void ask_for_parameters();
  void keep_subscribed(double now);
  void suspect_silent_requests(double now);
  void suspect_silent_address(double now);
  void receive(const Report& report, double now);
  void receive_verification(const Report& report);
  void follow_contact(const OperatorCommand& command);
  void receive_housekeeping(const Report& report, double now);
  void receive_parameters(const Report& report);
  [[nodiscard]] std::string name_of(std::uint32_t request) const;
  [[nodiscard]] UtcNs flight_time(double now) const;
  bool keep(const std::string& name, const Console::Bytes& file);

  OperatorSettings settings_;
  Say say_;
  Console console_;
  FlightView view_;
  std::map<std::uint32_t, Request> requests_;
  FileUplinks uplinks_{console_, say_};
  bool sealing_ = false, seal_fault_reported_ = false;
  std::uint64_t forgotten_reported_ = 0;
  double received_s_ = 0, status_s_ = 0, asked_s_ = 0, begun_s_ = now_s();
  bool silence_reported_ = false;
  UtcNs received_utc_ = 0;
  std::vector<bool> parameters_reported_;
  std::vector<std::vector<std::size_t>> parameters_wanted_;  ///< by the operator, numbers from 0 of each request
  std::optional<double> parameters_crc_;
  std::size_t failures_ = 0;
  double pause_s_ = 0;
  bool quit_ = false;
};

}  // namespace ilp::console
