// Reads the rows of an answer of the server.
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

  /// Takes over a result of libpq, and releases the one before.
  void hold(pg_result* result);
  void clear() { hold(nullptr); }

  /// Number of rows.
  [[nodiscard]] int count() const;
  /// Read a value. Return false if it is NULL or has another type, or if there is no such row or column.
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
