# Run by embed_texts: writes TEXT_OUTPUT, in which TEXT_NAME is the content of TEXT_FILE, byte by byte. Escapes need no knowledge of
# the text's own quotes and encoding, short adjacent literals stay below every compiler's limit.
file(READ ${TEXT_FILE} digits HEX)
string(LENGTH "${digits}" length)
set(digits_per_line 160)
set(position 0)
set(literal)
while(position LESS length)
  string(SUBSTRING "${digits}" ${position} ${digits_per_line} line)
  string(REGEX REPLACE "(..)" "\\\\x\\1" line "${line}")
  string(APPEND literal "    \"${line}\"\n")
  math(EXPR position "${position} + ${digits_per_line}")
endwhile()
file(WRITE ${TEXT_OUTPUT} "#include \"${TEXT_HEADER}\"\n
namespace ${TEXT_NAMESPACE} {\n
namespace {
constexpr char ${TEXT_NAME}Text[] =
${literal}    \"\";
}  // namespace\n
const std::string_view ${TEXT_NAME}(${TEXT_NAME}Text, sizeof(${TEXT_NAME}Text) - 1);\n
}  // namespace ${TEXT_NAMESPACE}\n")
