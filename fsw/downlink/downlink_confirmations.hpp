// Reads the ground's confirmations of files that Downlink has sent, and lets lost files be sent again.
#pragma once

#include "fsw/downlink/downlink_part.hpp"

namespace ilp {

class DownlinkConfirmations : public DownlinkPart {
 public:
  using DownlinkPart::DownlinkPart;

  /// Asks the link for confirmations of some files. Returns whether any file was confirmed or dropped.
  Result<bool> confirm(State& after);
  /// After the record of a sent file was found damaged: marks all product layers that were sent and not confirmed as
  /// unsent. Works on a few products per call. Returns whether the state has changed.
  Result<bool> check_products(State& after);

 private:
  /// Asks for the confirmation of one file. Returns true if the file was confirmed or dropped.
  Result<bool> read_confirmation(DownlinkRecord record, State& after);
  Status confirm_layers(const DownlinkRecord& record, ProductRecord product);
  /// Erases the record of a file whose confirmation is overdue, so that the file is made again. Not for products.
  Result<bool> drop_if_lost(const DownlinkRecord& record, State& after);
};

}  // namespace ilp
