// The operator's console: sends commands from typed lines, and shows reports, events, housekeeping and received files.
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
  as_reported,  ///< as the flight's parameter `link.authentication` says; no until the parameter is known
  no,
  yes
};

struct OperatorSettings {
  ConsoleSettings link;
  std::filesystem::path out;       ///< folder for received files; empty: the station receives none
  TimeNs interval = 2 * ns_per_s;  ///< interval of housekeeping reports
  SealFiles seal_files = SealFiles::as_reported;
};

class OperatorConsole {
 public:
  /// Shows a line to the operator.
  using Say = std::function<void(const std::string&)>;

  /// Connects, and requests housekeeping and parameters; step() repeats the requests until they are answered. Throws
  /// std::runtime_error if there is no connection (TCP), or the folder cannot be written.
  OperatorConsole(OperatorSettings settings, Say say);

  /// Executes a line of the operator, and reports errors to the operator.
  void enter(const std::string& line);
  /// The two parts of `enter`. Both throw std::runtime_error that says what is wrong.
  [[nodiscard]] OperatorCommand parse(const std::string& line) const;
  void execute(const OperatorCommand& command);
  /// Receives for `seconds`, and shows what comes.
  void step(double seconds);

  [[nodiscard]] const FlightView& view() const { return view_; }
  /// Lines of the operator whose telecommands or files still wait for their last report.
  [[nodiscard]] std::vector<std::string> waiting() const;
  /// Number of lines that the console or the flight has refused.
  [[nodiscard]] std::size_t failures() const { return failures_ + uplinks_.failures(); }
  [[nodiscard]] bool wants_to_quit() const { return quit_; }
  [[nodiscard]] double pause_s() const { return pause_s_; }  ///< pause requested by the last line
  [[nodiscard]] bool closed() const { return console_.closed(); }
  /// Text on possible reasons why no report has come, and on what to do.
  [[nodiscard]] std::string silence_words() const;

 private:
  struct Request {
    std::string words;
    OperatorCommand command;
    double sent_s = 0;
    bool own = false;       ///< sent by the console itself; shown only if it fails
    bool received = false;  ///< a report about it has come, or the operator was told that none has come
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
  std::vector<std::vector<std::size_t>> parameters_wanted_;  ///< for each request of the operator, parameter indices
  std::optional<double> parameters_crc_;
  std::size_t failures_ = 0;
  double pause_s_ = 0;
  bool quit_ = false;
};

}  // namespace ilp::console
