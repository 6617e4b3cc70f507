// What Downlink learns from the ground about the files that it has sent.
#pragma once

#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

class DownlinkConfirmations : public DownlinkPart {
 public:
  using DownlinkPart::DownlinkPart;

  Status hear(State& after, bool& heard);
  /// The record of a file was damaged: everything that was sent and is not confirmed is sent again.
  Status check_products(State& after, bool& changed);

 private:
  Status hear_one(DownlinkRecord record, State& after, bool& settled, bool& heard);
  Status hear_layers(const DownlinkRecord& record, ProductRecord product);
  Status drop_if_lost(const DownlinkRecord& record, State& after, bool& settled, bool& heard);
};

}  // namespace ilp
