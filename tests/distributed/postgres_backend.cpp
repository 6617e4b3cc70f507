#include "tests/distributed/postgres_backend.hpp"

#include <stdio.h>

#include <fstream>

#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

std::string sql(const std::string& statements) {
  const TemporaryFolder folder;
  const std::string file = folder / "statements.sql";
  std::ofstream(file) << statements;
  const std::string command = environment("ILP_POSTGRES_SERVER") + " sql < " + file + " 2>&1";
  FILE* const pipe = popen(command.c_str(), "r");
  EXPECT_NE(pipe, nullptr);
  std::string printed;
  for (int c = pipe != nullptr ? fgetc(pipe) : EOF; c != EOF; c = fgetc(pipe)) printed += static_cast<char>(c);
  if (pipe != nullptr) {
    EXPECT_EQ(pclose(pipe), 0) << statements << "\n" << printed;
  }
  while (!printed.empty() && printed.back() == '\n') printed.pop_back();
  return printed;
}

void empty_database() {
  sql("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE usename='ilp';"
      "DROP SCHEMA public CASCADE; CREATE SCHEMA public AUTHORIZATION ilp; GRANT USAGE ON SCHEMA public TO PUBLIC");
}

}  // namespace ilp::test
