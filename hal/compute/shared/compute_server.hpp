// The other end of shared_compute.hpp, in the program of a compute device: takes jobs out of the memory of one flight
// after another and writes results. It may block and allocate; it is no part of the flight.
#pragma once

#include "hal/compute/shared/compute_memory.hpp"

namespace ilp {

class ComputeServer {
 public:
  explicit ComputeServer(const ComputeForms& forms) : header_(compute_header(forms)) {}
  ComputeServer(const ComputeServer&) = delete;
  ComputeServer& operator=(const ComputeServer&) = delete;
  ~ComputeServer();

  Status listen(const char* path);
  /// Waits for a flight, with which it goes on until that ends. `parse_error`: it is none, or has another layout.
  Status accept();
  /// Waits for the next job. `end_of_stream`: the flight has ended. A job whose input does not have its checksum is
  /// left out.
  Status next(ComputeJob& job);
  /// The job's output is complete.
  Status answer(const ComputeJob& job);
  /// Ends the connection to the flight.
  void leave();
  /// All that is shared with the flight.
  [[nodiscard]] std::span<std::byte> memory() const { return {memory_.at(0), header_.bytes}; }

 private:
  ComputeHeader header_;
  ComputeMemory memory_;
  int listener_ = -1;
  int socket_ = -1;
  std::uint32_t number_ = 0;  ///< of the latest job
};

}  // namespace ilp
