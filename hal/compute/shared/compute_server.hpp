// The end of the connection in the program of a compute device; shared_compute.hpp is the flight's end. The server
// reads jobs from the shared memory of one flight after another and announces results. It may block and allocate,
// because it is no part of the flight.
#pragma once

#include "hal/compute/shared/compute_memory.hpp"

namespace ilp {

class ComputeServer {
 public:
  explicit ComputeServer(const ComputeForms& forms) : header_(compute_header(forms)) {}
  ComputeServer(const ComputeServer&) = delete;
  ComputeServer& operator=(const ComputeServer&) = delete;
  ~ComputeServer();

  /// Makes the socket `path` (listen_compute).
  Status listen(const char* path);
  /// Waits for a flight to connect, and ends the connection to the flight before it. Returns `parse_error` if the
  /// client passes no memory, or one with another layout.
  Status accept();
  /// Waits for the next job; input and output lie in the shared memory. Skips jobs whose input does not have its
  /// checksum. Returns `end_of_stream` when the flight has ended.
  Status next(ComputeJob& job);
  /// Announces that the output of the job is complete.
  Status answer(const ComputeJob& job);
  /// Ends the connection to the flight.
  void leave();
  /// The memory shared with the flight, with its header.
  [[nodiscard]] std::span<std::byte> memory() const { return {memory_.at(0), header_.bytes}; }

 private:
  ComputeHeader header_;
  ComputeMemory memory_;
  int listener_ = -1;
  int socket_ = -1;
  std::uint32_t number_ = 0;  ///< number of the latest job
};

}  // namespace ilp
