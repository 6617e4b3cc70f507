#include "hal/compute/shared/compute_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "fsw/base/checksum.hpp"
#include "fsw/base/fields.hpp"
#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

constexpr std::size_t part_alignment = 4096;

std::size_t aligned(std::size_t bytes) {
  return (bytes + part_alignment - 1) / part_alignment * part_alignment;
}

}  // namespace

ComputeHeader compute_header(const ComputeForms& forms) {
  ComputeHeader header;
  header.layout = static_cast<std::uint32_t>(layout_digest<ComputeHeader>());
  std::size_t end = aligned(sizeof(ComputeHeader));
  for (std::size_t k = 0; k < compute_kinds; ++k) {
    ComputeMailbox& box = header.boxes[k];
    box.input_bytes = forms[k].input_bytes;
    box.layout = forms[k].layout;
    box.output_bytes = forms[k].output_bytes();
    box.input_offset = end;
    end += aligned(box.input_bytes);
    box.output_offset = end;
    end += aligned(box.output_bytes);
  }
  header.bytes = end;
  return header;
}

std::uint64_t compute_sum(std::span<const std::byte> bytes, ComputeKind kind, std::uint32_t number) {
  return checksum64(bytes, mix64(std::uint64_t{number} << 8U | static_cast<std::uint64_t>(kind)));
}

Status ComputeMemory::map_file(int file, std::size_t bytes) {
  void* const begin = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (begin == MAP_FAILED) return {StatusCode::io_error, errno};
  begin_ = static_cast<std::byte*>(begin);
  bytes_ = bytes;
  return {};
}

Status ComputeMemory::make(const ComputeHeader& header) {
  close();
  file_ = ::memfd_create("ilp-compute", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file_ < 0) return {StatusCode::io_error, errno};
  Status status;
  if (::ftruncate(file_, static_cast<off_t>(header.bytes)) != 0 ||
      ::fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    status = {StatusCode::io_error, errno};
  } else {
    status = map_file(file_, header.bytes);
  }
  if (!status.ok()) {
    close();
    return status;
  }
  std::memset(begin_, 0, bytes_);
  std::memcpy(begin_, &header, sizeof(header));
  return {};
}

Status ComputeMemory::map(int file, const ComputeHeader& expected) {
  close();
  struct stat info {};
  if (::fstat(file, &info) != 0) return {StatusCode::io_error, errno};
  if (static_cast<std::size_t>(info.st_size) != expected.bytes) return StatusCode::parse_error;
  ILP_TRY(map_file(file, expected.bytes));
  ComputeHeader there;
  std::memcpy(&there, begin_, sizeof(there));
  bool same = there.magic == expected.magic && there.layout == expected.layout && there.bytes == expected.bytes;
  for (std::size_t k = 0; k < compute_kinds; ++k) {
    const ComputeMailbox &p = there.boxes[k], &q = expected.boxes[k];
    same = same && p.input_offset == q.input_offset && p.output_offset == q.output_offset &&
           p.input_bytes == q.input_bytes && p.output_bytes == q.output_bytes && p.layout == q.layout;
  }
  if (same) return {};
  close();
  return StatusCode::parse_error;
}

void ComputeMemory::close() {
  if (begin_ != nullptr) ::munmap(begin_, bytes_);
  if (file_ >= 0) ::close(file_);
  begin_ = nullptr;
  bytes_ = 0;
  file_ = -1;
}

}  // namespace ilp
