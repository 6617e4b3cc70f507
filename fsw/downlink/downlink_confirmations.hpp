// What Downlink learns from the ground about the files that it has sent.
#pragma once

#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

class DownlinkConfirmations : public DownlinkPart {
 public:
  using DownlinkPart::DownlinkPart;

  Result<bool> confirm(State& after);
  /// The record of a file was damaged: everything that was sent and is not confirmed is sent again.
  Result<bool> check_products(State& after);

 private:
  /// Whether nothing more is expected of the file.
  Result<bool> read_confirmation(DownlinkRecord record, State& after);
  Status confirm_layers(const DownlinkRecord& record, ProductRecord product);
  Result<bool> drop_if_lost(const DownlinkRecord& record, State& after);
};

}  // namespace ilp
