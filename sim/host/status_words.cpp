#include "sim/host/status_words.hpp"

#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::ground {
namespace {

bool known(std::uint16_t code) {
  return is_status_code(code);
}

}  // namespace

std::string status_sentence(const Status& status) {
  return sim::status_sentence(status);
}

std::string event_name(std::uint16_t code) {
  return known(code) ? status_name(static_cast<StatusCode>(code)) : "code " + std::to_string(code);
}

std::string event_sentence(const EventRecord& event) {
  if (!known(event.code)) {
    return "unknown to this program, values " + std::to_string(event.a) + " and " + std::to_string(event.b);
  }
  return sim::status_sentence({static_cast<StatusCode>(event.code), event.a, event.b});
}

std::string event_advice(std::uint16_t code) {
  return known(code) ? status_advice(static_cast<StatusCode>(code)) : "use the ground software of the flight's version";
}

const char* severity_name(std::uint8_t severity) {
  switch (static_cast<Severity>(severity)) {
    case Severity::info:
      return "info";
    case Severity::low:
      return "low";
    case Severity::medium:
      return "medium";
    case Severity::high:
      return "high";
  }
  return "unknown";
}

const char* strip_end_words(StripEnd end) {
  switch (end) {
    case StripEnd::open:
      return "still open";
    case StripEnd::overlap_lost:
      return "overlap lost";
    case StripEnd::overlap_unknown:
      return "overlap unknown";
    case StripEnd::pose_lost:
      return "pose lost";
    case StripEnd::end_of_flight:
      return "end of flight";
    case StripEnd::commanded:
      return "ended by command";
    case StripEnd::count:
      break;
  }
  return "unknown reason";
}

const char* depth_verdict_words(DepthVerdict verdict) {
  switch (verdict) {
    case DepthVerdict::ok:
      return "ok";
    case DepthVerdict::no_partner:
      return "no stereo partner";
    case DepthVerdict::rectification_impossible:
      return "not rectifiable";
    case DepthVerdict::too_few_valid:
      return "too few valid depths";
    case DepthVerdict::count:
      break;
  }
  return "unknown verdict";
}

const char* pose_verdict_words(std::uint8_t sequence_verdict) {
  switch (static_cast<SequenceVerdict>(sequence_verdict)) {
    case SequenceVerdict::ok:
      return "ok";
    case SequenceVerdict::waiting:
      return "alone in its strip";
    case SequenceVerdict::too_few_matches:
      return "too few matches";
    case SequenceVerdict::two_view_failed:
      return "pair gives no pose";
    case SequenceVerdict::resection_failed:
      return "resection failed";
    case SequenceVerdict::implausible:
      return "implausible step";
    case SequenceVerdict::not_calibrated:
      return "camera not calibrated";
    case SequenceVerdict::ambiguous:
      return "two motions explain the pair";
    case SequenceVerdict::count:
      break;
  }
  return "unknown verdict";
}

const char* overlap_verdict_words(std::uint8_t overlap_verdict) {
  switch (static_cast<OverlapVerdict>(overlap_verdict)) {
    case OverlapVerdict::ok:
      return "ok";
    case OverlapVerdict::overlap_unknown:
      return "overlap unknown";
    case OverlapVerdict::texture_poor:
      return "poor texture";
    case OverlapVerdict::too_dark:
      return "too dark";
    case OverlapVerdict::blurred:
      return "blurred";
    case OverlapVerdict::count:
      break;
  }
  return "unknown verdict";
}

const char* scheme_words(ProductScheme scheme) {
  switch (scheme) {
    case ProductScheme::lossy_region:
      return "lossy, region first";
    case ProductScheme::lossless_region:
      return "lossless region";
    case ProductScheme::thumbnail:
      return "thumbnail";
    case ProductScheme::count:
      break;
  }
  return "unknown scheme";
}

}  // namespace ilp::ground
