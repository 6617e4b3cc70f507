#include "hal/camera/v4l2/buffer_pool.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>

namespace ilp {
namespace {

constexpr std::uint32_t wanted_buffers = 10;
// One is being exposed while another is examined.
constexpr std::uint32_t least_buffers = 2;
constexpr int patience = 8;  // refusals in a row until the stream is stopped

v4l2_buffer buffer_request(std::uint32_t index) {
  v4l2_buffer request{};
  request.index = index;
  request.type = frame_buffers;
  request.memory = V4L2_MEMORY_MMAP;
  return request;
}

}  // namespace

Status driver_fault(int error, unsigned long request) {
  return {StatusCode::camera_fault, error, static_cast<std::int64_t>(request & 0xFFU)};
}

Status BufferPool::map(std::uint32_t index, std::size_t image_bytes) {
  v4l2_buffer buffer = buffer_request(index);
  const int error = device_.control(VIDIOC_QUERYBUF, &buffer);
  if (error != 0) return driver_fault(error, VIDIOC_QUERYBUF);
  if (buffer.length < image_bytes) {
    return {StatusCode::camera_layout, buffer.length, static_cast<std::int64_t>(image_bytes)};
  }
  const int refused = device_.map(buffer.length, buffer.m.offset, slots_[index].bytes);
  if (refused != 0) return driver_fault(refused, VIDIOC_QUERYBUF);
  return {};
}

Status BufferPool::allocate(std::size_t image_bytes) {
  release();
  v4l2_requestbuffers request{};
  request.count = wanted_buffers;
  request.type = frame_buffers;
  request.memory = V4L2_MEMORY_MMAP;
  const int error = device_.control(VIDIOC_REQBUFS, &request);
  if (error != 0) return driver_fault(error, VIDIOC_REQBUFS);
  requested_ = true;
  if (request.count < least_buffers || request.count > slots_.size()) {
    return {StatusCode::camera_buffers, request.count, static_cast<std::int64_t>(slots_.size())};
  }
  for (std::uint32_t i = 0; i < request.count; ++i) {
    ILP_TRY(map(i, image_bytes));
    slots_[i].holder = Holder::nobody;
    count_ = i + 1;
  }
  return {};
}

int BufferPool::queue(std::uint32_t index) {
  v4l2_buffer buffer = buffer_request(index);
  const int error = device_.control(VIDIOC_QBUF, &buffer);
  if (error == 0) slots_[index].holder = Holder::driver;
  return error;
}

Status BufferPool::start() {
  refusals_ = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    const int error = queue(i);
    if (error != 0) return driver_fault(error, VIDIOC_QBUF);
  }
  int type = static_cast<int>(frame_buffers);
  const int error = device_.control(VIDIOC_STREAMON, &type);
  if (error != 0) return driver_fault(error, VIDIOC_STREAMON);
  streaming_ = true;
  return {};
}

Status BufferPool::queue_what_nobody_has() {
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (slots_[i].holder != Holder::nobody) continue;
    const int error = queue(i);
    refusals_ = error == 0 ? 0 : refusals_ + 1;
    if (refusals_ >= patience) return driver_fault(error, VIDIOC_QBUF);
  }
  return {};
}

Status BufferPool::take(VideoBuffer& buffer) {
  ILP_TRY(queue_what_nobody_has());
  const bool any = std::any_of(slots_.begin(), slots_.begin() + static_cast<std::ptrdiff_t>(count_),
                               [](const Slot& slot) { return slot.holder == Holder::driver; });
  if (!any) return StatusCode::not_ready;
  // It is polled first, because not every driver respects the non-blocking mode.
  bool readable = false;
  const int deaf = device_.wait(0, readable);
  if (deaf != 0) return driver_fault(deaf, VIDIOC_DQBUF);
  if (!readable) return StatusCode::not_ready;
  v4l2_buffer taken = buffer_request(0);
  const int error = device_.control(VIDIOC_DQBUF, &taken);
  if (error == EAGAIN) return StatusCode::not_ready;
  if (error != 0) return driver_fault(error, VIDIOC_DQBUF);
  if (taken.index >= count_ || slots_[taken.index].holder != Holder::driver) {
    return {StatusCode::camera_protocol, taken.index, static_cast<std::int64_t>(count_)};
  }
  slots_[taken.index].holder = Holder::flight;
  buffer = {taken.index, taken.sequence, taken.flags, taken.bytesused, taken.timestamp.tv_sec, taken.timestamp.tv_usec};
  return {};
}

void BufferPool::give_back(std::uint32_t index) {
  slots_[index].holder = Holder::nobody;
  const int error = queue(index);
  refusals_ = error == 0 ? 0 : refusals_ + 1;
}

void BufferPool::release() {
  int type = static_cast<int>(frame_buffers);
  // The result does not matter: the next start detects a fault.
  if (streaming_) static_cast<void>(device_.control(VIDIOC_STREAMOFF, &type));
  streaming_ = false;
  for (std::size_t i = 0; i < count_; ++i) {
    device_.unmap(slots_[i].bytes);
    slots_[i] = {};
  }
  count_ = 0;
  v4l2_requestbuffers none{};
  none.type = frame_buffers;
  none.memory = V4L2_MEMORY_MMAP;
  if (requested_) static_cast<void>(device_.control(VIDIOC_REQBUFS, &none));
  requested_ = false;
}

}  // namespace ilp
