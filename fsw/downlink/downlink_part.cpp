#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

bool DownlinkPart::rests(FileClass kind, std::int64_t id) const {
  return work_.quarantine.rests(kind, id, wiring_.clock.now());
}

bool DownlinkPart::abandoned(FileClass kind, std::int64_t id) const {
  return work_.quarantine.abandoned(kind, id);
}

bool DownlinkPart::fits(const State& after, std::int64_t bytes) const {
  // A file that is larger than a whole pass would never be sent. A pass may begin with it, at the cost of the files
  // after it.
  return bytes <= work_.free_bytes || after.pass_bytes == 0 || wiring_.mission.pass_period_s <= 0;
}

bool DownlinkPart::may_go(const State& after, std::int64_t bytes, std::int64_t most) {
  work_.something_waits = true;
  return bytes <= most && fits(after, bytes);
}

}  // namespace ilp
