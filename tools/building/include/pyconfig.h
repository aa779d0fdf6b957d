/* Nothing: Python.h beside this file names no type that differs between platforms. */
