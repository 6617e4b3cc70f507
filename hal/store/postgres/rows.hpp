// The rows that the server has answered.
#pragma once

#include <cstdint>
#include <span>

struct pg_result;

namespace ilp::postgres {

class Rows {
 public:
  Rows() = default;
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;
  ~Rows() { clear(); }

  /// Takes what libpq has returned.
  void hold(pg_result* result);
  void clear() { hold(nullptr); }

  [[nodiscard]] int count() const;
  /// False for NULL, for another type, and for a place that does not exist.
  [[nodiscard]] bool number(int row, int column, std::int64_t& value) const;
  [[nodiscard]] bool number(int row, int column, float& value) const;
  [[nodiscard]] bool number(int row, int column, double& value) const;
  [[nodiscard]] bool bytes(int row, int column, std::span<const std::uint8_t>& value) const;

 private:
  template <typename Bits, typename Number>
  [[nodiscard]] bool read(int row, int column, std::uint32_t type, Number& value) const;
  [[nodiscard]] const std::uint8_t* value_at(int row, int column) const;

  pg_result* result_ = nullptr;
};

}  // namespace ilp::postgres
