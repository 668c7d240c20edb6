// The count by voice, where the patient wants it and the browser can speak.
import { useEffect, useRef } from 'react';

const STORED_AS = 'telemotion.countAloud';

export function canSpeak(): boolean {
  return 'speechSynthesis' in window && 'SpeechSynthesisUtterance' in window;
}

/** Off until somebody asked for it on this device. */
export function wantsVoice(): boolean {
  try {
    return canSpeak() && localStorage.getItem(STORED_AS) === 'yes';
  } catch {
    return false;
  }
}

export function keepVoice(isWanted: boolean): void {
  try {
    localStorage.setItem(STORED_AS, isWanted ? 'yes' : 'no');
  } catch {
    // A browser that keeps nothing asks again next time.
  }
}

/** Say a text whenever its number grows; what is being said gives way to what is new. */
export function useVoice(isOn: boolean, number: number, text: string): void {
  const last = useRef(number);
  useEffect(() => {
    const isNew = number > last.current;
    last.current = number;
    if (!isOn || !isNew || !text || !canSpeak()) return;
    const said = new SpeechSynthesisUtterance(text);
    said.lang = document.documentElement.lang || 'en';
    window.speechSynthesis.cancel();
    window.speechSynthesis.speak(said);
  }, [isOn, number, text]);
}
