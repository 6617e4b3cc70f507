#include "fsw/packets/service_verification.hpp"

namespace ilp {
namespace {

bool has_step(std::uint8_t subtype) {
  return subtype == verification::progress || subtype == verification::progress_failed;
}
bool is_failure(std::uint8_t subtype) {
  return subtype % 2 == 0;
}

}  // namespace

void encode_verification(const Tailoring& tailoring, const VerificationReport& report, ByteWriter& out) {
  out.u32(report.request);
  if (has_step(report.subtype)) out.number(report.step, tailoring.step);
  if (!is_failure(report.subtype)) return;
  out.number(report.code, tailoring.failure_code);
  out.put(report.failure_data);
}

Status decode_verification(const Tailoring& tailoring, std::uint8_t subtype, std::span<const std::uint8_t> data,
                           VerificationReport& report) {
  ByteReader in(data);
  report = {};
  report.subtype = subtype;
  report.request = in.u32();
  if (has_step(subtype)) report.step = static_cast<std::uint32_t>(in.number(tailoring.step));
  if (is_failure(subtype)) {
    report.code = static_cast<std::uint32_t>(in.number(tailoring.failure_code));
    report.failure_data = in.take(in.left());
  }
  if (!in.ok() || in.left() != 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  return {};
}

}  // namespace ilp
