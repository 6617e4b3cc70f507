#include "fsw/commanding/telecommand_answer.hpp"

#include <array>

namespace ilp {

void Answer::send(std::uint8_t subtype, std::uint32_t step, const Status& failure) {
  std::array<std::uint8_t, 16> values{};
  ByteWriter data(values);
  data.number(static_cast<std::uint64_t>(failure.a), 8);
  data.number(static_cast<std::uint64_t>(failure.b), 8);
  VerificationReport report;
  report.subtype = subtype;
  report.request = request_.packet;
  report.step = step;
  report.code = static_cast<std::uint32_t>(failure.code);
  report.failure_data = data.written();
  std::array<std::uint8_t, 32> octets{};
  ByteWriter out(octets);
  encode_verification(writer_.settings().tailoring, report, out);
  // It fits: the widths are those of a tailoring.
  static_cast<void>(writer_.report(verification::service, subtype, request_.source, out.written()));
}

void Answer::report_stage(Stage stage) {
  if (stage == Stage::accepted && (ack_flags_ & ack::acceptance) != 0) send(verification::acceptance, 0, {});
  if (stage == Stage::started && (ack_flags_ & ack::start) != 0) send(verification::start, 0, {});
}

void Answer::accept() {
  if (stage_ != Stage::received) return;
  stage_ = Stage::accepted;
  if (!postponed_) report_stage(stage_);
}

void Answer::start() {
  accept();
  if (stage_ != Stage::accepted) return;
  stage_ = Stage::started;
  if (!postponed_) report_stage(stage_);
}

void Answer::progress(std::uint32_t step) {
  if ((ack_flags_ & ack::progress) != 0) send(verification::progress, step, {});
}

void Answer::finish(const Status& status) {
  if (status.ok()) {
    start();
    if ((ack_flags_ & ack::completion) != 0) send(verification::completion, 0, {});
    return;
  }
  if (postponed_ && stage_ != Stage::received) report_stage(Stage::accepted);
  if (postponed_ && stage_ == Stage::started) report_stage(Stage::started);
  const std::uint8_t subtypes[] = {verification::acceptance_failed, verification::start_failed,
                                   verification::completion_failed};
  send(subtypes[static_cast<std::size_t>(stage_)], 0, status);
}

Status Answer::report(std::uint8_t service, std::uint8_t subtype, std::span<const std::uint8_t> data) {
  return writer_.report(service, subtype, request_.source, data);
}

}  // namespace ilp
