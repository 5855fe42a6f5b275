# SPDX-License-Identifier: Apache-2.0
# The interpreter itself, for tests: what PATH names may be a script that looks for one first, at each of a test's hundreds of calls.
find_package(Python3 COMPONENTS Interpreter REQUIRED)
execute_process(COMMAND ${Python3_EXECUTABLE} -c "import sys; print(sys.executable)"
                OUTPUT_VARIABLE Python3_EXECUTABLE OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
