// Adaptive binary arithmetic coding: a range coder with carry (as in LZMA; G. N. N. Martin, "Range encoding", 1979).
// Each context learns its probability at two speeds.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace ilp {

inline constexpr unsigned bit_coder_probability_bits = 15;
inline constexpr std::uint32_t bit_coder_most_zero = (1U << bit_coder_probability_bits) - 1;

/// Probability that the next bit of a context is 0, in units of 2^-24: the mean of a fast and a slow estimate.
struct BitProbability {
  static constexpr unsigned bits = 24, fast = 4, slow = 7;
  std::int32_t quick = 1 << (bits - 1);
  std::int32_t steady = 1 << (bits - 1);

  /// Returns the probability in units of 2^-15; it is never 0 and never 1.
  [[nodiscard]] std::uint32_t zero() const {
    const auto mean = static_cast<std::uint32_t>(quick + steady) >> (bits + 1 - bit_coder_probability_bits);
    return mean < 1 ? 1 : mean > bit_coder_most_zero ? bit_coder_most_zero : mean;
  }
  void learn(std::uint32_t bit) {
    const std::int32_t target = bit != 0 ? 0 : 1 << bits;
    quick += (target - quick) / (1 << fast);
    steady += (target - steady) / (1 << slow);
  }
  /// Returns true if learning `bit` again changes nothing.
  [[nodiscard]] bool saturated(std::uint32_t bit) const {
    BitProbability next = *this;
    next.learn(bit);
    return next.quick == quick && next.steady == steady;
  }
};

inline constexpr std::uint32_t bit_coder_renewal = 1U << 24U;

/// Codes runs of the usual bit in a saturated context, several bits at once. Returns the number of bits it coded, which
/// may be below `most`.
class SaturatedRange {
 public:
  /// Codes bits that are 0, which have the highest probability: range := (range >> 15) (2^15 - 1) for each bit, as long
  /// as the range stays at or above `least`.
  static std::size_t take_zeros(std::uint32_t& range, std::uint32_t least, std::size_t most) {
    const std::uint32_t upper = range >> bit_coder_probability_bits;
    // Each bit reduces the upper part by this step: 1 for each 2^15 begun.
    const std::uint32_t step = ((upper - 1) >> bit_coder_probability_bits) + 1;
    const std::uint32_t last =
        std::max((least - 1) / bit_coder_most_zero + 1, ((step - 1) << bit_coder_probability_bits) + 1);
    if (upper < last) return 0;
    const std::size_t count = std::min<std::size_t>((upper - last) / step + 1, most);
    range = (upper - step * static_cast<std::uint32_t>(count - 1)) * bit_coder_most_zero;
    return count;
  }
  /// Codes bits that are 1 while 0 has the lowest probability: range := range - (range >> 15) for each bit, as long as
  /// the total decrease is at most `spare` and the range needs no renewal.
  static std::size_t take_ones(std::uint32_t& range, std::uint32_t spare, std::size_t most) {
    constexpr std::size_t at_once = 8;
    std::size_t count = 0;
    for (; count + at_once <= most; count += at_once) {
      const std::uint32_t taken = at_once * (range >> bit_coder_probability_bits);
      if (taken > spare || range - taken < bit_coder_renewal) break;
      const std::uint32_t before = range;
#pragma GCC unroll 8
      for (std::size_t i = 0; i < at_once; ++i) range -= range >> bit_coder_probability_bits;
      spare -= before - range;
    }
    return count;
  }
};

/// Encodes bits into a fixed buffer. Bytes that do not fit are counted but not stored.
template <std::size_t Contexts>
class BitEncoder {
 public:
  BitEncoder(std::uint8_t* out, std::size_t capacity) : out_(out), capacity_(capacity) {}

  void encode(std::uint32_t context, std::uint32_t bit) {
    BitProbability& p = probabilities_[context];
    const std::uint32_t bound = (range_ >> bit_coder_probability_bits) * p.zero();
    if (bit == 0) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    p.learn(bit);
    while (range_ < bit_coder_renewal) {
      range_ <<= 8U;
      shift_low();
    }
  }

  /// Has the same result as `count` calls of encode(context, bit), in less time.
  void encode_run(std::uint32_t context, std::uint32_t bit, std::size_t count) {
    std::size_t done = 0;
    for (; done < count && !probabilities_[context].saturated(bit); ++done) encode(context, bit);
    const std::uint32_t zero = probabilities_[context].zero();
    std::uint32_t range = range_;
    for (; done < count; ++done) {
      const std::uint32_t before = range;
      if (bit == 0 && zero == bit_coder_most_zero) {
        done += SaturatedRange::take_zeros(range, bit_coder_renewal, count - done);
      } else if (bit != 0 && zero == 1) {
        done += SaturatedRange::take_ones(range, range, count - done);
        low_ += before - range;
      }
      if (done == count) break;
      const std::uint32_t bound = (range >> bit_coder_probability_bits) * zero;
      if (bit == 0) {
        range = bound;
      } else {
        low_ += bound;
        range -= bound;
      }
      while (range < bit_coder_renewal) {
        range <<= 8U;
        shift_low();
      }
    }
    range_ = range;
  }

  /// Ends the code and returns its size, bytes. If the size exceeds the capacity, the output is invalid.
  std::size_t finish() {
    for (int i = 0; i < 5; ++i) shift_low();
    return size_;
  }

 private:
  void put(std::uint8_t byte) {
    // The very first byte is always 0.
    if (!first_) {
      if (size_ < capacity_) out_[size_] = byte;
      ++size_;
    }
    first_ = false;
  }

  void shift_low() {
    if (low_ < 0xff000000U || low_ >= (std::uint64_t{1} << 32U)) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32U);
      put(static_cast<std::uint8_t>(cache_ + carry));
      for (; pending_ > 0; --pending_) put(static_cast<std::uint8_t>(0xffU + carry));
      cache_ = static_cast<std::uint8_t>(low_ >> 24U);
    } else {
      ++pending_;
    }
    low_ = (low_ & 0x00ffffffU) << 8U;
  }

  std::uint8_t* out_;
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::size_t pending_ = 0;
  std::uint8_t cache_ = 0;
  bool first_ = true;
  std::array<BitProbability, Contexts> probabilities_{};
};

/// Decodes bits. Any bytes decode to something; used() shows whether the decoder read as many as the encoder wrote.
template <std::size_t Contexts>
class BitDecoder {
 public:
  BitDecoder(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {
    for (int i = 0; i < 4; ++i) code_ = (code_ << 8U) | next();
  }

  std::uint32_t decode(std::uint32_t context) {
    BitProbability& p = probabilities_[context];
    const std::uint32_t bound = (range_ >> bit_coder_probability_bits) * p.zero();
    const std::uint32_t bit = code_ < bound ? 0U : 1U;
    if (bit == 0) {
      range_ = bound;
    } else {
      code_ -= bound;
      range_ -= bound;
    }
    p.learn(bit);
    while (range_ < bit_coder_renewal) {
      range_ <<= 8U;
      code_ = (code_ << 8U) | next();
    }
    return bit;
  }

  /// Has the same result as calls of decode(context) until one returns a bit other than `usual`, at most `most` calls.
  /// Returns the number of usual bits. If it is below `most`, the other bit has been decoded, too.
  std::size_t decode_run(std::uint32_t context, std::uint32_t usual, std::size_t most) {
    std::size_t count = 0;
    while (count < most && !probabilities_[context].saturated(usual)) {
      if (decode(context) != usual) return count;
      ++count;
    }
    // The probability of the usual bit does not change until the other bit comes.
    const std::uint32_t zero = probabilities_[context].zero();
    std::uint32_t range = range_, code = code_;
    for (; count < most; ++count) {
      const std::uint32_t before = range;
      if (usual == 0 && zero == bit_coder_most_zero) {
        count += SaturatedRange::take_zeros(range, std::max(code + 1, bit_coder_renewal), most - count);
      } else if (usual != 0 && zero == 1) {
        count += SaturatedRange::take_ones(range, code, most - count);
        code -= before - range;
      }
      if (count == most) break;
      const std::uint32_t bound = (range >> bit_coder_probability_bits) * zero;
      const std::uint32_t bit = code < bound ? 0U : 1U;
      if (bit != usual) break;
      if (bit == 0) {
        range = bound;
      } else {
        code -= bound;
        range -= bound;
      }
      while (range < bit_coder_renewal) {
        range <<= 8U;
        code = (code << 8U) | next();
      }
    }
    range_ = range;
    code_ = code;
    if (count < most) static_cast<void>(decode(context));
    return count;
  }

  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  std::uint32_t next() {
    const std::uint32_t byte = used_ < size_ ? bytes_[used_] : 0U;
    ++used_;
    return byte;
  }

  const std::uint8_t* bytes_;
  std::size_t size_;
  std::size_t used_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::array<BitProbability, Contexts> probabilities_{};
};

}  // namespace ilp
