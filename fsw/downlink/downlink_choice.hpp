// Chooses the next file that Downlink sends, in the order that downlink.hpp states, and sends it.
#pragma once

#include "fsw/downlink/downlink_files.hpp"

namespace ilp {

class DownlinkChoice : public DownlinkPart {
 public:
  DownlinkChoice(const DownlinkWiring& wiring, const Cursor& cursor, State& state, DownlinkWork& work,
                 DownlinkWorkspace& workspace)
      : DownlinkPart(wiring, cursor, state, work, workspace), files_(wiring, cursor, state, work, workspace) {}

  /// Sends the next file. Returns false if none is due.
  Result<bool> send_next(State& after);

 private:
  // Each function sends a file of one kind, of at most `most` bytes, and returns false if there is none.
  Result<bool> send_owed(State& after);
  Result<bool> send_class(FileClass kind, std::int64_t most, State& after);
  Result<bool> send_overdue(State& after);
  Result<bool> send_planned(std::int64_t most, State& after);
  Result<bool> send_in_order(std::int64_t most, State& after);
  Result<bool> send_next_records(std::int64_t most, State& after);
  Result<bool> send_next_points(std::int64_t most, State& after);
  Result<bool> send_events_if_due(std::int64_t most, State& after);
  /// The first late file of a class that does not rest in quarantine; null if there is none.
  [[nodiscard]] const LateFile* late_one(const State& after, FileClass kind) const;
  /// Reads the ground's requests to refine products.
  Status find_requests();
  [[nodiscard]] bool requested(std::int64_t keyframe_id) const;
  /// Reads the first waiting product after `product` whose keyframe's records have been sent. Returns false if there is
  /// none.
  Result<bool> next_waiting(const State& after, ProductRecord& product);
  [[nodiscard]] bool waits(const State& after, const ProductRecord& product) const;
  /// Collects the candidates for plan_pass.
  Status gather(const State& after);

  DownlinkFiles files_;
};

}  // namespace ilp
