// Chooses the next file that Downlink sends, by the order that its header states, and has it made.
#pragma once

#include "fsw/downlink/downlink_files.hpp"

namespace ilp {

class DownlinkChoice : public DownlinkPart {
 public:
  DownlinkChoice(const DownlinkWiring& wiring, const Cursor& cursor, State& state, DownlinkWork& work,
                 DownlinkWorkspace& workspace)
      : DownlinkPart(wiring, cursor, state, work, workspace), files_(wiring, cursor, state, work, workspace) {}

  Result<bool> send_next(State& after);

 private:
  // `most` limits the bytes of the file.
  Result<bool> send_owed(State& after);
  Result<bool> send_class(FileClass kind, std::int64_t most, State& after);
  Result<bool> send_overdue(State& after);
  Result<bool> send_planned(std::int64_t most, State& after);
  Result<bool> send_in_order(std::int64_t most, State& after);
  Result<bool> send_next_records(std::int64_t most, State& after);
  Result<bool> send_next_points(std::int64_t most, State& after);
  Result<bool> send_events_if_due(std::int64_t most, State& after);
  /// The first of the late files of a class that is not quarantined; null: none.
  [[nodiscard]] const LateFile* late_one(const State& after, FileClass kind) const;
  Status find_requests();
  [[nodiscard]] bool requested(std::int64_t keyframe_id) const;
  /// The first waiting product after `product` whose records have been sent.
  Result<bool> next_waiting(const State& after, ProductRecord& product);
  [[nodiscard]] bool waits(const State& after, const ProductRecord& product) const;
  Status gather(const State& after);

  DownlinkFiles files_;
};

}  // namespace ilp
