// The verification reports (service 1) on one telecommand.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/service_verification.hpp"
#include "fsw/packets/telemetry_writer.hpp"

namespace ilp {

/// Success is reported if the telecommand requests it, failure always. A failure is reported for the first stage that
/// was not reached: [1,2] before accept(), [1,4] before start(), [1,8] after start(). Failure data are the two values
/// of the Status, each as a signed number of eight octets.
class Answer {
 public:
  Answer(TelemetryWriter& writer, const RequestId& request, std::uint8_t ack_flags)
      : writer_(writer), request_(request), ack_flags_(ack_flags) {}

  void accept();
  void start();
  void progress(std::uint32_t step);
  /// Reports completion if `status` is ok, otherwise the failure.
  void finish(const Status& status);
  /// Sends a report of another service to the source of the telecommand.
  Status report(std::uint8_t service, std::uint8_t subtype, std::span<const std::uint8_t> data);

  [[nodiscard]] const RequestId& request() const { return request_; }
  [[nodiscard]] std::uint8_t ack_flags() const { return ack_flags_; }
  [[nodiscard]] bool accepted() const { return stage_ != Stage::received; }
  /// Completion will be reported later.
  void keep_open() { open_ = true; }
  [[nodiscard]] bool open() const { return open_; }
  /// Acceptance and start will be reported later, unless the telecommand fails before.
  void postpone() { postponed_ = true; }
  [[nodiscard]] bool postponed() const { return postponed_; }
  /// The telecommand was started in an earlier step.
  void continue_started() { stage_ = Stage::started; }

 private:
  enum class Stage : std::uint8_t { received, accepted, started };
  void send(std::uint8_t subtype, std::uint32_t step, const Status& failure);
  void report_stage(Stage stage);

  TelemetryWriter& writer_;
  RequestId request_;
  std::uint8_t ack_flags_;
  Stage stage_ = Stage::received;
  bool open_ = false;
  bool postponed_ = false;
};

}  // namespace ilp
