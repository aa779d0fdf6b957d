// Serial numbers from a scanner that types, a keyboard, or the keys on a touch screen.

const KEYS = [..."1234567890ABCDEFGHIJKLMNOPQRSTUVWXYZ-"];
const ERASE = "⌫";

export class Keys {
  constructor({ form, input, pad, keypad, send }) {
    Object.assign(this, { form, input, pad, keypad });
    form.onsubmit = (event) => {
      event.preventDefault();
      const serial = input.value.trim();
      input.value = "";
      if (serial) send(serial);
    };
    keypad.replaceChildren(...[...KEYS, ERASE].map((key) => this.#key(key)));
    pad.onclick = () => this.#toggle();
    // a scanner types wherever the page is
    addEventListener("keydown", (event) => this.#anywhere(event));
  }

  #key(key) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = key;
    button.onclick = () => {
      this.input.value = key === ERASE ? this.input.value.slice(0, -1) : this.input.value + key;
    };
    return button;
  }

  #toggle() {
    this.keypad.hidden = !this.keypad.hidden;
    this.pad.setAttribute("aria-expanded", String(!this.keypad.hidden));
  }

  #anywhere(event) {
    if (this.form.hidden || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target === this.input) return;
    const button = event.target instanceof HTMLButtonElement;
    if (event.key.length === 1 && !(button && event.key === " ")) this.input.focus();
    else if (event.key === "Enter" && this.input.value && !button) this.form.requestSubmit();
  }
}
