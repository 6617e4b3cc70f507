# SCRIPTS (separated by commas, the main one last) become one script without their imports and exports, and with STYLE the
# string literals of OUT.
string(REPLACE "," ";" SCRIPTS "${SCRIPTS}")
set(script "")
foreach(file ${SCRIPTS})
  file(READ ${file} text)
  string(REGEX REPLACE "(^|\n)import [^\n]*" "\\1" text "${text}")
  string(REGEX REPLACE "(^|\n)export " "\\1" text "${text}")
  string(APPEND script "${text}")
endforeach()
file(READ ${STYLE} style)
file(WRITE ${OUT} "#include \"sim/ground/report/page_resource.hpp\"\n\nnamespace ilp::report {\nstd::string_view page_script() {\n  return R\"ilp_page(${script})ilp_page\";\n}\nstd::string_view page_style() {\n  return R\"ilp_page(${style})ilp_page\";\n}\n}  // namespace ilp::report\n")
